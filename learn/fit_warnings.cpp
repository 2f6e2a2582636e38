#include "learn/fit_warnings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "insertion/scene_scaling.hpp"
#include "learn/free_course.hpp"
#include "learn/tilt_yields.hpp"

namespace ferrule {
namespace {

constexpr double kHardly = 0.3;  // of the variance that the course leaves

// The episodes that the law was fitted to.
std::vector<Samples> fitted_to(const DemonstrationSet& set, const LawFile& law) {
  std::vector<Samples> all;
  for (const Demonstration& d : set.demonstrations) {
    const auto& held_out = law.trained_on.held_out;
    if (std::none_of(held_out.begin(), held_out.end(),
                     [&](const TrainedEpisode& e) { return e.file == d.file; }))
      all.push_back(samples(d, law.reaction_time));
  }
  return all;
}

void warn_of_gains(const DemonstrationSet& set, const LawFile& law,
                   std::vector<std::string>& warnings) {
  const std::vector<Samples> episodes = fitted_to(set, law);
  const Eigen::Array3d share = free_course(law.kind, law.law().gains(), episodes).share;
  for (const Gain& gain : gain_table(law.kind)) {
    const std::string name = gain.name;
    if (name.find("yield_") == name.npos) continue;
    const int axis = name.back() - 'x';
    if (!(share[axis] < kHardly)) continue;
    warnings.push_back(fmt::format(
        "{} is not determined by these forces: they explain {:.1f} % of what the velocity along {} "
        "varies at the same height; the true gain may be many times larger, whatever the interval "
        "says",
        name, 100 * std::max(0.0, share[axis]), name.back()));
  }
  if (const double tilts = tilt_yields(episodes).share; tilts < kLeastToldByMoments)
    warnings.push_back(
        fmt::format("the law does not tilt: the moments explain {:.1f} % of how the hands tilted",
                    100 * tilts));
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
