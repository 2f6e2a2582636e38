#include "learn/fit_warnings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>

#include "controller/statistics.hpp"
#include "insertion/scene_scaling.hpp"
#include "learn/free_course.hpp"
#include "learn/tilt_yields.hpp"
#include "sim/base/control_period.hpp"

namespace ferrule {
namespace {

constexpr double kHardly = 0.3;  // of the variance that the course leaves
constexpr double kUneven = 0.1;  // of a yield, between its intervals

// Of a gain that answers a force along x, y or z: 0, 1 or 2.
int axis_of(const std::string& gain) {
  return gain.back() - 'x';
}

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

// Two parts of the rows, for each of which the hand may have a yield of its own.
struct Parts {
  const char *one, *other;
  bool (*in_other)(const Sample&, double median_force);  // [N]
  const char* hint;
};
constexpr std::array kParts = {
    Parts{"outside the bore", "inside", [](const Sample& s, double) { return s.depth > 0; },
          "--law guarded has both"},
    Parts{"under small forces", "under large ones",
          [](const Sample& s, double median) { return s.wrench.head<3>().norm() > median; },
          "no law has both"}};

double median_force(const std::vector<Samples>& episodes) {
  std::vector<double> forces;
  for (const Samples& episode : episodes)
    for (const Sample& s : episode) forces.push_back(s.wrench.head<3>().norm());
  return quantile(std::move(forces), 0.5);
}

// What the law's gains would be in one of the parts alone.
std::vector<FittedGain> yields_in(const Parts& parts, bool other, double median_force,
                                  const LawFile& law, const std::vector<Samples>& episodes) {
  std::vector<Samples> rows(episodes.size());
  for (std::size_t i = 0; i < episodes.size(); ++i)
    std::copy_if(episodes[i].begin(), episodes[i].end(), std::back_inserter(rows[i]),
                 [&](const Sample& s) { return parts.in_other(s, median_force) == other; });
  return free_course(law.kind, law.law().gains(), rows).yields;
}

// Of the yields along axes whose forces tell them (`share`, of free_course), of a law in which they
// are the same at any depth and force, but for those in the bore.
void warn_of_uneven_yields(const std::vector<Samples>& episodes, const LawFile& law,
                           const Eigen::Array3d& share, std::vector<std::string>& warnings) {
  const double median = median_force(episodes);
  for (const Parts& parts : kParts) {
    const auto one = yields_in(parts, false, median, law, episodes),
               other = yields_in(parts, true, median, law, episodes);
    for (std::size_t i = 0; i < one.size(); ++i) {
      const std::string name = gain_table(law.kind)[i].name;
      const FittedGain &a = one[i], &b = other[i];
      if (std::isnan(a.low) || std::isnan(b.low) || share[axis_of(name)] < kHardly) continue;
      const double apart = std::max(a.low, b.low) - std::min(a.high, b.high);
      if (apart <= kUneven * std::max(a.value, b.value)) continue;
      warnings.push_back(
          fmt::format("{} is not one number: {} {:.3g} ({:.3g} to {:.3g}), {} {:.3g} ({:.3g} to "
                      "{:.3g}); {}",
                      name, parts.one, a.value, a.low, a.high, parts.other, b.value, b.low, b.high,
                      parts.hint));
    }
  }
}

void warn_of_gains(const DemonstrationSet& set, const LawFile& law,
                   std::vector<std::string>& warnings) {
  const std::vector<Samples> episodes = fitted_to(set, law);
  const Eigen::Array3d share = free_course(law.kind, law.law().gains(), episodes).share;
  for (const Gain& gain : gain_table(law.kind)) {
    const std::string name = gain.name;
    if (name.find("yield_") == name.npos) continue;
    const double explained = share[axis_of(name)];
    if (!(explained < kHardly)) continue;
    warnings.push_back(fmt::format(
        "{} is not determined by these forces: they explain {:.1f} % of what the velocity along {} "
        "varies at the same height; the true gain may be many times larger, whatever the interval "
        "says",
        name, 100 * std::max(0.0, explained), name.back()));
  }
  if (law.kind != LawKind::phased && law.kind != LawKind::saturated)
    warn_of_uneven_yields(episodes, law, share, warnings);
  if (const double tilts = tilt_yields(episodes).share; tilts < kLeastToldByMoments)
    warnings.push_back(
        fmt::format("the law does not tilt: the moments explain {:.1f} % of how the hands tilted",
                    100 * tilts));
}

}  // namespace

double time_without_force(const MakeController& make, const Scene& scene) {
  const Scaling scaling = scene_scaling(scene);
  const double speed = scaling.motion * scene.limits.speed, entrance = registered_entrance(scene);
  const std::unique_ptr<Controller> controller = make(0);
  HandPose hand = HandPose::Zero();
  hand[0] = scaling.motion * scene.start.distance;
  const HandPose start = hand;
  for (double t = 0; t <= scene.limits.time; t += kControlPeriod) {
    if (-hand[0] >= scaling.motion * scene.success.depth) return t;
    const HandTwist v = controller->command(observe(HandWrench::Zero(), hand, start, entrance, t));
    if (!v.allFinite()) break;
    hand += kControlPeriod * limit_speed(v, speed);
  }
  return std::numeric_limits<double>::infinity();
}

std::vector<std::string> fit_warnings(const DemonstrationSet& set,
                                      const ControllerFile& controller) {
  std::vector<std::string> warnings;
  if (const auto* law = std::get_if<LawFile>(&controller)) warn_of_gains(set, *law, warnings);
  for (const EpisodeCopy& copy : set.copies) warnings.push_back(copy.text());
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
