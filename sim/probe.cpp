#include "sim/probe.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/insertion.hpp"
#include "sim/minimum_jerk.hpp"
#include "sim/random.hpp"
#include "sim/sampled_run.hpp"

namespace ferrule {
namespace {

constexpr std::uint64_t kProbeSeed = 20;
constexpr double kLongest = 16, kLongestWithDrag = 30, kLongestInertial = 2;  // of a probe [s]
// Of a probe [m].
constexpr double kDeepest = 100e-6, kDeepestWithDrag = 20e-6, kDeepestInertial = 5e-6;
constexpr double kMostLean = 0.03;  // [rad]

std::vector<Pose> motion(const Scene& scene, const State& start, std::uint64_t k) {
  RandomStream random(kProbeSeed, k, Draw::plan);
  const World& world = scene.world;
  const double deepest = world.dynamics == Dynamics::inertial ? kDeepestInertial
                         : world.drag                         ? kDeepestWithDrag
                                                              : kDeepest;
  const double c = world.annulus.clearance(), depth = std::min(scene.success.depth, deepest);
  const auto around = [&](double scale) { return scale * (2 * random.uniform() - 1); };
  const double push =
      c + 0.7 * scene.limits.force / world.holder.stiffness.block<2, 2>(1, 1).norm();
  // Half of them lean as the scene's starts do, half as much as the bore allows.
  const double lean = std::min(k % 2 ? scene.start.tilt_sd : kMostLean, c / depth);

  std::vector<Pose> tips = {start.tip};
  const auto next = [&](double x, double y, double z, double ty, double tz) {
    Pose p;
    p << x, y, z, ty, tz;
    tips.push_back(p);
  };
  const double outside = world.profile.lead_in_length + 2e-6, mouth = 2e-6;
  const Vector2d aside(around(0.6 * c), around(0.6 * c));
  const double ty = around(lean), tz = around(lean);
  const bool misaligned = k % 4 == 3;  // straight down from where it is
  // From wall to wall across the bore, as deep as the scene goes; every other time near its mouth,
  // and out while pressed.
  const bool across = world.drag && k % 2 == 1 && !misaligned, at_mouth = k % 8 == 5;
  if (across) {
    const double deep = at_mouth ? 0.25 * depth : scene.success.depth;
    const double less = at_mouth ? -mouth : std::max(0.5 * deep, deep - deepest);
    const double angle = std::numbers::pi * random.uniform();
    const double y = push * std::cos(angle), z = push * std::sin(angle);
    tips.front() << -deep, aside, 0, 0;
    next(-deep, y, z, 0, 0);
    next(-less, y, z, 0, 0);
    next(-less, aside.x(), aside.y(), 0, 0);
    next(-deep, aside.x(), aside.y(), 0, 0);
    next(-deep, y, z, 0, 0);
    next(-deep, -y, -z, 0, 0);
    next(-less, -y, -z, 0, 0);
  } else if (misaligned) {
    next(-depth, start.tip[1], start.tip[2], start.tip[3], start.tip[4]);
  } else {
    tips.front() << mouth, aside, ty, tz;
    next(-depth, aside.x(), aside.y(), ty, tz);
  }
  for (const double side : {1.0, -1.0}) {
    if (across) break;
    const double angle = std::numbers::pi * random.uniform();
    const double y = side * push * std::cos(angle), z = side * push * std::sin(angle);
    next(-depth, y, z, ty + around(lean), tz + around(lean));
    next(-(0.4 + 0.2 * random.uniform()) * depth, y, z, ty, tz);
  }
  if (!across) next(misaligned ? outside : mouth, aside.x(), aside.y(), 0, 0);

  const double lever = depth + world.annulus.fibre_radius;
  const auto way_to = [&](std::size_t i) {
    const Pose move = tips[i] - tips[i - 1];
    return move.head<3>().norm() + lever * move.tail<2>().norm();
  };
  // Where nothing depends on time the hand may as well be faster than the scene's.
  double speed = scene.limits.speed, all = 0;
  for (std::size_t i = 1; i < tips.size(); ++i) all += way_to(i);
  if (!world.drag && world.dynamics == Dynamics::quasi_static)
    speed = std::max(speed, kPeakOfMinimumJerk * all / (0.75 * kLongest));
  std::vector<Pose> hand = {tips.front() - world.holder.sag};
  const double longest = world.dynamics == Dynamics::inertial ? kLongestInertial
                         : world.drag                         ? kLongestWithDrag
                                                              : kLongest;
  for (std::size_t i = 1; i < tips.size(); ++i) {
    const Pose from = hand.back(), to = tips[i] - world.holder.sag;
    const double part = speed * (across ? 1 : 0.5 + 0.5 * random.uniform());
    const auto steps = static_cast<std::size_t>(std::ceil(
        std::max(kPeakOfMinimumJerk * way_to(i) / part, 2 * kSpeedingUp) / kSamplePeriod));
    for (std::size_t n = 1; n <= steps; ++n) {
      if (static_cast<double>(hand.size()) * kSamplePeriod > longest) return hand;
      const double p = static_cast<double>(n) / static_cast<double>(steps);
      hand.push_back(from + minimum_jerk(p) * (to - from));
    }
  }
  return hand;
}

}  // namespace

std::uint64_t probes_of(const Scene& scene) noexcept {
  return scene.world.dynamics == Dynamics::inertial ? 2 : 8;
}

Probe make_probe(const Scene& scene, std::uint64_t k) {
  // Free flight tells nothing.
  Pose from = draw_start(scene, kProbeSeed, k).tip;
  from[0] = std::min(from[0], scene.world.profile.lead_in_length + 5e-6);
  Probe probe;
  probe.hand = motion(scene, at_rest(scene.world, from), k);
  probe.start = at_rest(scene.world, probe.hand.front() + scene.world.holder.sag);
  return probe;
}

}  // namespace ferrule
