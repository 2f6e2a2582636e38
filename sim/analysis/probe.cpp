#include "sim/analysis/probe.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/analysis/sampled_run.hpp"
#include "sim/base/control_period.hpp"
#include "sim/base/elementary.hpp"
#include "sim/base/minimum_jerk.hpp"
#include "sim/base/random.hpp"
#include "sim/scene/draw.hpp"

namespace ferrule {
namespace {

constexpr std::uint64_t kProbeSeed = 20;
constexpr double kLongest = 16, kLongestWithDrag = 30, kLongestInertial = 2;  // of a probe [s]
// Of a probe [m].
constexpr double kDepth = 100e-6, kDepthWithDrag = 20e-6, kDepthInertial = 5e-6;
constexpr double kMostTilt = 0.03;  // [rad]
constexpr double kMouth = 2e-6;     // so far outside, a fibre is out of the bore [m]

double deepest(const World& world) noexcept {
  return world.dynamics == Dynamics::inertial ? kDepthInertial
         : depends_on_speed(world.laws)       ? kDepthWithDrag
                                              : kDepth;
}

double longest(const World& world) noexcept {
  return world.dynamics == Dynamics::inertial ? kLongestInertial
         : depends_on_speed(world.laws)       ? kLongestWithDrag
                                              : kLongest;
}

// How far the hand goes aside to press the fibre against a wall [m].
double push(const Scene& scene) noexcept {
  return scene.world.annulus.clearance() +
         0.7 * scene.limits.force / scene.world.holder.stiffness.block<2, 2>(1, 1).norm();
}

double around_zero(RandomStream& random, double scale) noexcept {
  return scale * (2 * random.uniform() - 1);
}

Vector2d within_the_bore(RandomStream& random, const World& world) noexcept {
  const double reach = 0.6 * world.annulus.clearance(), y = around_zero(random, reach);
  return {y, around_zero(random, reach)};
}

Vector2d in_any_direction(RandomStream& random) noexcept {
  const double angle = std::numbers::pi * random.uniform();
  return {elementary::cos(angle), elementary::sin(angle)};
}

Pose tip_at(double x, const Vector2d& e, const Vector2d& t = Vector2d::Zero()) noexcept {
  return PoseVector(x, e, t).full();
}

// In, pressed to one side and the other on the way back, and out; or, if misaligned, straight down
// from the start and so on.
std::vector<Pose> in_and_out(const Scene& scene, const Pose& start, bool misaligned,
                             double most_tilt, RandomStream& random) {
  const World& world = scene.world;
  const double depth = std::min(scene.success.depth, deepest(world));
  const double largest_tilt = std::min(most_tilt, world.annulus.clearance() / depth);
  const auto any_tilt = [&] {
    const double y = around_zero(random, largest_tilt);
    return Vector2d(y, around_zero(random, largest_tilt));
  };
  const Vector2d aside = within_the_bore(random, world), tilt = any_tilt();
  std::vector<Pose> tips;
  if (misaligned)
    tips = {start, tip_at(-depth, start.segment<2>(1), start.tail<2>())};
  else
    tips = {tip_at(kMouth, aside, tilt), tip_at(-depth, aside, tilt)};
  for (const double side : {1.0, -1.0}) {
    const Vector2d pressed = side * push(scene) * in_any_direction(random);
    tips.push_back(tip_at(-depth, pressed, tilt + any_tilt()));
    tips.push_back(tip_at(-(0.4 + 0.2 * random.uniform()) * depth, pressed, tilt));
  }
  tips.push_back(tip_at(misaligned ? world.profile.lead_in_length + kMouth : kMouth, aside));
  return tips;
}

// From wall to wall, pulled and pushed while pressed: as deep as the scene goes, or near the mouth
// and out of it.
std::vector<Pose> from_wall_to_wall(const Scene& scene, bool at_mouth, RandomStream& random) {
  const double most = deepest(scene.world), depth = scene.success.depth;
  const double deep = at_mouth ? 0.25 * std::min(depth, most) : depth;
  const double less = at_mouth ? -kMouth : std::max(0.5 * deep, deep - most);
  const Vector2d aside = within_the_bore(random, scene.world);
  const Vector2d pressed = push(scene) * in_any_direction(random);
  return {tip_at(-deep, aside),    tip_at(-deep, pressed), tip_at(-less, pressed),
          tip_at(-less, aside),    tip_at(-deep, aside),   tip_at(-deep, pressed),
          tip_at(-deep, -pressed), tip_at(-less, -pressed)};
}

std::vector<Pose> motion(const Scene& scene, const State& start, std::uint64_t k) {
  RandomStream random(kProbeSeed, k, Draw::plan);
  const World& world = scene.world;
  const bool misaligned = k % 4 == 3,
             across = depends_on_speed(world.laws) && k % 2 == 1 && !misaligned;
  // Half of them tilt as the scene's starts do, half as much as the bore allows.
  const double most_tilt = k % 2 ? scene.start.tilt_sd : kMostTilt;
  const std::vector<Pose> tips = across
                                     ? from_wall_to_wall(scene, k % 8 == 5, random)
                                     : in_and_out(scene, start.tip, misaligned, most_tilt, random);

  const double lever = std::min(scene.success.depth, deepest(world)) + world.annulus.fibre_radius;
  const auto distance_to = [&](std::size_t i) {
    const Pose move = tips[i] - tips[i - 1];
    return move.head<3>().norm() + lever * move.tail<2>().norm();
  };
  // Where nothing depends on time the hand may as well be faster than the scene's.
  double speed = scene.limits.speed, all = 0;
  for (std::size_t i = 1; i < tips.size(); ++i) all += distance_to(i);
  if (!depends_on_speed(world.laws) && world.dynamics == Dynamics::quasi_static)
    speed = std::max(speed, kPeakOfMinimumJerk * all / (0.75 * kLongest));
  std::vector<Pose> hand = {tips.front() - world.holder.sag};
  for (std::size_t i = 1; i < tips.size(); ++i) {
    const Pose from = hand.back(), to = tips[i] - world.holder.sag;
    const double part = speed * (across ? 1 : 0.5 + 0.5 * random.uniform());
    const auto steps = static_cast<std::size_t>(std::ceil(
        std::max(kPeakOfMinimumJerk * distance_to(i) / part, 2 * kSpeedingUp) / kControlPeriod));
    for (std::size_t n = 1; n <= steps; ++n) {
      if (static_cast<double>(hand.size()) * kControlPeriod > longest(world)) return hand;
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
