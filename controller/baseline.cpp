#include "controller/baseline.hpp"

#include <algorithm>
#include <filesystem>
#include <numbers>

#include "controller/blind_spiral.hpp"
#include "controller/searching_operator.hpp"
#include "insertion/scene_scaling.hpp"

namespace ferrule {

const std::vector<std::string>& baseline_names() {
  static const std::vector<std::string> names = {kStraight, kSpiral, kSearching};
  return names;
}

bool is_baseline(const std::string& name) {
  const std::vector<std::string>& all = baseline_names();
  std::error_code error;
  return std::find(all.begin(), all.end(), name) != all.end() &&
         !std::filesystem::is_regular_file(name, error);
}

MakeController baseline(const std::string& name, const Scene& scene, std::uint64_t seed) {
  if (name == kSearching) return searching_operator(scene, 0.8, seed);
  const Scaling scaling = scene_scaling(scene);
  const double speed = scaling.motion * scene.limits.speed;
  if (name == kStraight) return controller_maker(ConstantVelocity(speed));
  return controller_maker(
      BlindSpiral(speed, scaling.force * scene.limits.force / 12,
                  std::numbers::sqrt2 * scaling.motion * scene.world.annulus.clearance()));
}

}  // namespace ferrule
