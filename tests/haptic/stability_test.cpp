#include "haptic/stability.hpp"

#include <complex>

#include "capture/episode.hpp"
#include "haptic/passivity.hpp"
#include "haptic/virtual_coupling.hpp"
#include "insertion/rendering.hpp"
#include "insertion/scene_scaling.hpp"
#include "sim/solver/held_stiffness.hpp"
#include "sim/solver/step.hpp"
#include "tests/compare.hpp"
#include "tests/hand_and_device.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

using Eigen::Matrix3d;
using testing::HandAndDevice;

// A device that a spring K vibrates on slowly beside the loop's lateness t = T (d + 1/2): with
// w t = 0.2 the passivity bound is within 1 % of what stability takes.
DeviceProfile device(double K, double period, int delay, double damping) {
  DeviceProfile d{};
  d.period = period;
  d.delay_periods = delay;
  const double late = period * (delay + 0.5) / 0.2;
  d.mass = K * late * late;
  d.damping = damping;
  d.max_force = 8;
  d.max_stiffness = 1e9;
  return d;
}

double energy(const DeviceProfile& d, const HandAndDevice& hand, double K) {
  return 0.5 * d.mass * hand.v * hand.v + 0.5 * K * hand.x * hand.x;
}

struct Ends {
  double first, last, most;  // energy over the first and last twentieth, and ever [J]
};

// A spring K with a damper B, pulled out and let go; with or without the passivity controller.
Ends drop_opened(const DeviceProfile& d, double K, double B, double seconds,
                 bool controlled = false, double* damping = nullptr) {
  HandAndDevice hand(d);
  hand.x = 1e-3;
  PassivityController passivity(d.period, 0.5 * d.mass / d.period);
  double before = hand.x;
  const auto steps = static_cast<int>(seconds / d.period);
  Ends ends{};
  for (int n = 0; n < steps; ++n) {
    const double x = hand.measured();
    double force = -K * x - B * (x - before) / d.period;
    before = x;
    if (controlled) force = passivity.pass({x, 0, 0}, {force, 0, 0})[0];
    if (damping) *damping = std::max(*damping, passivity.damping());
    hand.advance(force);
    const double e = energy(d, hand, K);
    ends.most = std::max(ends.most, e);
    if (n < steps / 20) ends.first = std::max(ends.first, e);
    if (n >= steps - steps / 20) ends.last = std::max(ends.last, e);
  }
  return ends;
}

TEST(Stability, BoundIsTheSupremumOfColgateAndSchenkel) {
  for (const int delay : {0, 1, 2, 5})
    for (const double K : {100.0, 3000.0}) {
      const DeviceProfile d = device(K, 1e-3, delay, 1);
      double most = 0;
      for (int i = 1; i < 20000; ++i) {
        const std::complex<double> z = std::polar(1.0, M_PI * i / 20000);
        const std::complex<double> H = K * std::pow(z, -delay);
        const double there = 0.5 * d.period * ((1.0 - 1.0 / z) * H).real() / (1 - z.real());
        most = std::max(most, there);
      }
      EXPECT_CLOSE(most, damping_needed(d, K), 1e-6);
      for (const double B : {-0.7, 0.3}) {
        double with_damper = 0;
        for (int i = 1; i <= 20000; ++i) {
          const std::complex<double> z = std::polar(1.0, M_PI * i / 20000);
          const std::complex<double> H = (K + B * (1.0 - 1.0 / z) / d.period) * std::pow(z, -delay);
          with_damper =
              std::max(with_damper, 0.5 * d.period * ((1.0 - 1.0 / z) * H).real() / (1 - z.real()));
        }
        EXPECT_LE(with_damper, damping_needed(d, K, B) * (1 + 1e-9));
      }
    }
}

TEST(Stability, BoundsAreInverseToEachOther) {
  DeviceProfile d = device(1000, 1e-3, 2, 3);
  d.coulomb = 0.05;
  d.resolution = 20e-6;
  d.max_stiffness = 1500;
  for (const double B : {0.0, 1.0})
    EXPECT_CLOSE(damping_needed(d, passive_stiffness(d, B), B), d.damping, 1e-12);
  EXPECT_EQ(passive_stiffness(d, 4), 0);
  for (const double K : {0.1, 3.0})
    for (const double B : {0.0, 1e-4}) {
      const double magnified = largest_force_scaling(d, 250, K, B) / 250;
      const double room =
          std::max({damping_needed(d, magnified * K, magnified * B) / d.damping,
                    magnified * K / resting_stiffness(d), magnified * K / d.max_stiffness});
      EXPECT_CLOSE(room, 1, 1e-12);
    }
  EXPECT_EQ(largest_force_scaling(d, 250, 0, 0), INFINITY);
}

// A wall in the hand's world, felt by a grip that moves the hand `gain` times as far.
TEST(Stability, AGainMovesTheBoundsWithIt) {
  constexpr double K = 1000;
  for (const double gain : {0.2, 1.0, 5.0})
    for (const double share : {0.95, 1.05}) {
      DeviceProfile d = device(gain * K, 1e-3, 1, 0);
      d.damping = share * damping_needed(d, gain * K);
      EXPECT_EQ(damping_needed(at_gain(d, gain), K) < at_gain(d, gain).damping, share > 1);
      const Ends ends = drop_opened(d, gain * K, 0, 60 * d.mass / d.damping);
      EXPECT_EQ(ends.last<0.2 * ends.first, share> 1);
      d.resolution = 30e-6;
      d.coulomb = 0.04;
      d.max_stiffness = 1500;
      EXPECT_CLOSE(resting_stiffness(at_gain(d, gain)), resting_stiffness(d) / gain, 1e-12);
      EXPECT_CLOSE(at_gain(d, gain).max_stiffness, d.max_stiffness / gain, 1e-12);
    }
}

TEST(Stability, CouplingLeavesTheDeviceSomeDamping) {
  for (const double b : {0.01, 2.0, 20.0})
    for (const int delay : {0, 3}) {
      DeviceProfile d = device(1000, 1e-3, delay, b);
      const Coupling c = stable_coupling(d);
      EXPECT_CLOSE(damping_needed(d, c.stiffness, c.damping), 0.9 * b, 1e-12);
      d.max_stiffness = 0.1;
      EXPECT_EQ(stable_coupling(d).stiffness, 0.1);
    }
}

struct Wall {
  double K, period;
  int delay;
};

class StabilityOfAWall : public ::testing::TestWithParam<Wall> {};

// Let go on a wall with a damper B, with `margin` less damping than the bound and as much more, for
// so many times m/b.
void fades_above_and_grows_below(const Wall& wall, double B, double margin, double decays) {
  const auto of_damping = [&](double b) { return device(wall.K, wall.period, wall.delay, b); };
  const double K = wall.K, bound = damping_needed(of_damping(0), K, B);
  const auto ends = [&](double share) {
    const DeviceProfile d = of_damping(share * bound);
    return drop_opened(d, K, B, decays * d.mass / bound);
  };
  const Ends above = ends(1 + margin), below = ends(1 - margin);
  EXPECT_LT(above.last, 0.2 * above.first);
  EXPECT_GT(below.last, 5 * below.first);
}

TEST_P(StabilityOfAWall, EnergyFadesAboveTheBoundAndGrowsBelowIt) {
  fades_above_and_grows_below(GetParam(), 0, 0.05, 60);
}

TEST_P(StabilityOfAWall, ANegativeDamperAsksForAsMuch) {
  const auto [K, period, delay] = GetParam();
  // A damper that is differentiated from positions acts a little late.
  fades_above_and_grows_below(GetParam(), -damping_needed(device(K, period, delay, 0), K), 0.25,
                              30);
}

TEST_P(StabilityOfAWall, PassivityControllerBoundsTheEnergyOnBothSides) {
  const auto [K, period, delay] = GetParam();
  if (delay > 0) return;  // its observer sees the force that acts only without delay
  const double bound = damping_needed(device(K, period, delay, 0), K);
  double damping = 0;
  const DeviceProfile enough = device(K, period, delay, 1.5 * bound);
  const Ends calm = drop_opened(enough, K, 0, 60 * enough.mass / bound, true, &damping);
  EXPECT_LT(calm.last, 0.2 * calm.first);
  const DeviceProfile little = device(K, period, delay, 0.3 * bound);
  const double seconds = 60 * little.mass / bound;
  EXPECT_GT(drop_opened(little, K, 0, seconds).last, 1e6 * calm.first);
  damping = 0;
  const Ends kept = drop_opened(little, K, 0, seconds, true, &damping);
  EXPECT_GT(damping, 0);
  EXPECT_LT(kept.most, 2 * calm.first);
  EXPECT_LT(kept.last, kept.first);
}

INSTANTIATE_TEST_SUITE_P(Walls, StabilityOfAWall,
                         ::testing::Values(Wall{300, 1e-3, 0}, Wall{1000, 1e-3, 0},
                                           Wall{3000, 0.5e-3, 0}, Wall{3000, 2e-3, 0},
                                           Wall{1000, 1e-3, 1}, Wall{3000, 0.25e-3, 3}));

TEST(Stability, AQuantisedSpringRestsExactlyBelowItsBound) {
  for (const double resolution : {10e-6, 50e-6})
    for (const double coulomb : {0.02, 0.06})
      for (const double share : {0.5, 0.97, 1.03, 2.0}) {
        DeviceProfile d = device(1000, 1e-3, 0, 0);
        d.resolution = resolution;
        d.coulomb = coulomb;
        d.mass = 0.1;
        const double K = share * resting_stiffness(d);
        d.damping = 3 * damping_needed(d, K);
        HandAndDevice hand(d);
        hand.hand_force = 10.5 * K * resolution;  // between two steps
        int at_rest = 0;
        for (int n = 0; n < 4000; ++n) {
          hand.advance(-K * hand.measured());
          at_rest = hand.v == 0 ? at_rest + 1 : 0;
        }
        if (share < 1)
          EXPECT_GT(at_rest, 1000) << share;
        else
          EXPECT_LT(at_rest, 50) << share;
      }
}

// The real scene with its step(): the fibre's end on the bore wall, felt sideways.
struct Touching {
  Scene scene = load_scene("demo");
  Scaling scaling = scene_scaling(scene);
  StepResult now;
  double K = 0;  // felt sideways [N/m]
  Vector3d force = Vector3d::Zero();

  Touching() {
    const World& world = scene.world;
    now = StepResult(at_rest(world, testing::pose(20e-6, 0, 0)));
    Pose hand = now.state.command;
    for (int i = 0; i < 200; ++i) advance(hand = hand - testing::pose(0.2e-6, 0, 0));
    for (int i = 0; i < 300; ++i) advance(hand = hand - testing::pose(0, 20e-9, 0));
    for (int i = 0; i < 10; ++i) advance(hand);
    K = scaling.force / scaling.motion * held_stiffness(world, now.state)(1, 1);
  }
  void advance(const Pose& hand) {
    step_on(scene.world, hand, 1e-3, now);
    EXPECT_EQ(now.status, StepStatus::ok);
    force = scaling.wrench_to_hand(now.holder).head<3>();
  }
};

// A device with `share` of the damping needed, let go beside its rest on the wall: the hand's
// largest distance from there over the first and last tenth [m].
std::pair<double, double> let_go_on_the_wall(double share, bool controlled) {
  Touching loop;
  EXPECT_TRUE(loop.now.state.contact[kEnd].closed);
  EXPECT_CLOSE(loop.K, 1692, 0.02);  // of the holder's 0.5 N/m, magnified 3384 times
  const DeviceProfile d =
      device(loop.K, 1e-3, 0, share * damping_needed(device(loop.K, 1e-3, 0, 0), loop.K));
  PassivityController passivity(d.period, 0.5 * d.mass / d.period);
  HandAndDevice hand(d);
  const HandPose rest = loop.scaling.motion_to_hand(loop.now.state.command);
  const Vector3d held = loop.force;  // what the hand leans against
  hand.hand_force = -held.y();
  hand.x = 2e-6;
  double first = 0, last = 0;
  for (int n = 0; n < 400; ++n) {
    HandPose pose = rest;
    pose[1] += hand.x;
    loop.advance(loop.scaling.motion_to_tip(pose));
    Vector3d force = loop.force;
    if (controlled) force = held + passivity.pass(pose.head<3>(), force - held);
    hand.advance(force.y());
    if (n < 40) first = std::max(first, std::abs(hand.x));
    if (n >= 360) last = std::max(last, std::abs(hand.x));
  }
  return {first, last};
}

TEST(Stability, OfARealSceneTurnsAtTheSameBound) {
  const auto [calm_first, calm_last] = let_go_on_the_wall(1.25, false);
  EXPECT_LT(calm_last, 0.3 * calm_first);
  const auto [wild_first, wild_last] = let_go_on_the_wall(0.8, false);
  EXPECT_GT(wild_last, 3 * wild_first);
}

TEST(Stability, PassivityControllerBoundsARealScene) {
  const auto [calm_first, calm_last] = let_go_on_the_wall(1.25, true);
  EXPECT_LT(calm_last, 0.3 * calm_first);
  const auto [kept_first, kept_last] = let_go_on_the_wall(0.8, true);
  EXPECT_LT(kept_first, 4e-6);
  EXPECT_LT(kept_last, 1.1 * kept_first);
}

// The bench scene's fibre pressed endwise on the front face: hundreds of kN/m in the hand.
double wandering_on_the_face(bool coupled) {
  const Scene scene = load_scene("bench");
  const World& world = scene.world;
  const Scaling scaling = scene_scaling(scene);
  const double magnified = scaling.force / scaling.motion;
  const DeviceProfile d = load_device_profile("pen");
  const double face = world.profile.lead_in_length;
  StepResult result(at_rest(world, testing::pose(face + 0.05e-6, 150e-6, 0)));
  const State& state = result.state;
  HandAndDevice hand(d);
  hand.hand_force = -2;
  const HandPose begin = scaling.motion_to_hand(state.command);
  VirtualCoupling coupling(stable_coupling(d), d.period, begin.head<3>());
  Vector3d force = Vector3d::Zero();
  double low = INFINITY, high = -INFINITY;
  for (int n = 0; n < 3000; ++n) {
    HandPose pose = begin;
    pose[0] += hand.measured();
    if (coupled) {
      const Matrix3d K = magnified * held_stiffness(world, state).topLeftCorner<3, 3>();
      pose.head<3>() = coupling.move(pose.head<3>(), force, K);
    }
    step_on(world, scaling.motion_to_tip(pose), d.period, result);
    force = scaling.wrench_to_hand(result.holder - world.holder.weight).head<3>();
    hand.advance(std::clamp(coupled ? coupling.force().x() : force.x(), -d.max_force, d.max_force));
    if (n < 2500) continue;
    low = std::min(low, hand.x);
    high = std::max(high, hand.x);
  }
  return high - low;
}

TEST(Stability, TheCouplingHoldsWhatTheSceneAloneShakes) {
  EXPECT_GT(wandering_on_the_face(false), 1e-3);
  EXPECT_LT(wandering_on_the_face(true), 30e-6);
}

}  // namespace
}  // namespace ferrule
