#include "learn/fit_warnings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "insertion/scene_scaling.hpp"
#include "learn/samples.hpp"

namespace ferrule {
namespace {

constexpr double kHardly = 0.1;  // of a velocity's variance

// Share of the variance of each velocity that the law explains, over the demonstrations it was
// fitted to.
Eigen::Array3d explained(const DemonstrationSet& set, const LawFile& law) {
  const Law fitted = law.law();
  Eigen::Array3d sum = Eigen::Array3d::Zero(), square = sum, error = sum;
  double n = 0;
  for (const Demonstration& d : set.demonstrations) {
    const auto& held_out = law.trained_on.held_out;
    if (std::any_of(held_out.begin(), held_out.end(),
                    [&](const TrainedEpisode& e) { return e.file == d.file; }))
      continue;
    for (const Sample& sample : samples(d, law.reaction_time)) {
      const Eigen::Array3d v = sample.velocity.array();
      const Eigen::Vector3d answer = law_velocity(law.kind, fitted.gains().data(), sample);
      sum += v;
      square += v * v;
      error += (v - answer.array()).square();
      n += 1;
    }
  }
  const Eigen::Array3d variance = square - sum * sum / std::max(n, 1.0);
  return (variance > 0).select(1 - error / variance, 0);
}

void warn_of_gains(const DemonstrationSet& set, const LawFile& law,
                   std::vector<std::string>& warnings) {
  const Eigen::Array3d share = explained(set, law);
  for (const Gain& gain : gain_table(law.kind)) {
    const std::string name = gain.name;
    if (name.find("yield_") == name.npos) continue;
    const int axis = name.back() - 'x';
    if (axis == 0 || !(share[axis] < kHardly)) continue;  // v_x follows the law's own course too
    warnings.push_back(fmt::format(
        "{} is not determined by these forces: they explain {:.1f} % of the velocity along {}; the "
        "true gain may be many times larger, whatever the interval says",
        name, 100 * std::max(0.0, share[axis]), name.back()));
  }
}

}  // namespace

double time_without_force(const MakeController& make, const Scene& scene) {
  constexpr double kPeriod = 1e-3;
  const Scaling scaling = scene_scaling(scene);
  const double speed = scaling.motion * scene.limits.speed, entrance = registered_entrance(scene);
  const std::unique_ptr<Controller> controller = make(0);
  HandPose hand = HandPose::Zero();
  hand[0] = scaling.motion * scene.start.distance;
  const HandPose start = hand;
  for (double t = 0; t <= scene.limits.time; t += kPeriod) {
    if (-hand[0] >= scaling.motion * scene.success.depth) return t;
    const HandTwist v = controller->command(observe(HandWrench::Zero(), hand, start, entrance, t));
    if (!v.allFinite()) break;
    hand += kPeriod * limit_speed(v, speed);
  }
  return std::numeric_limits<double>::infinity();
}

std::vector<std::string> fit_warnings(const DemonstrationSet& set,
                                      const ControllerFile& controller) {
  std::vector<std::string> warnings;
  if (const auto* law = std::get_if<LawFile>(&controller)) warn_of_gains(set, *law, warnings);
  if (set.beyond > 0)
    warnings.push_back(fmt::format(
        "{} of {} successful episodes were left out, drawn at random: a fit takes {} rows of 10 ms",
        set.beyond, set.beyond + set.demonstrations.size(), DemonstrationSet::kMostRows));
  for (const std::string& document : set.documents) {
    const std::string what = "a scene of the episodes";
    const Scene scene = parse_scene(parse_json(document, what), what);
    if (time_without_force(maker(controller), scene) <= scene.limits.time) continue;
    warnings.push_back(fmt::format(
        "too slow for its trials: even where it feels nothing it does not reach {:g} um within the "
        "{:g} s of scene {}",
        1e6 * scene.success.depth, scene.limits.time, scene.name));
    break;
  }
  return warnings;
}

}  // namespace ferrule
