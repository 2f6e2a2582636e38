#include "insertion/imperfect_hand.hpp"

#include <cmath>

#include "tests/compare.hpp"

namespace ferrule {
namespace {

constexpr double kTick = 1e-3;
const Scaling kMagnified{.motion = 250, .force = 8e5};

HandPose at(double x, double y = 0, double tilt = 0) {
  HandPose pose = HandPose::Zero();
  pose[0] = x, pose[1] = y, pose[3] = tilt;
  return pose;
}

TEST(ImperfectHand, WithoutErrorsMovesBitForBit) {
  ImperfectHand hand({}, kMagnified, kTick);
  for (const double x : {0.1, 0.37, -0.2}) EXPECT_EQ(hand.holder(at(x, 1 / x)), at(x, 1 / x));
}

TEST(ImperfectHand, GainScalesMotionFromWhereItBegins) {
  ImperfectHand hand({.gain = 0.6}, kMagnified, kTick);
  EXPECT_EQ(hand.holder(at(0.5, 0.1)), at(0.5, 0.1));
  const HandPose holder = hand.holder(at(0.7, -0.1, 0.02));
  EXPECT_CLOSE(holder[0], 0.5 + 0.6 * 0.2, 1e-14);
  EXPECT_CLOSE(holder[1], 0.1 - 0.6 * 0.2, 1e-14);
  EXPECT_CLOSE(holder[3], 0.6 * 0.02, 1e-14);
}

TEST(ImperfectHand, DelayComesLaterInWholeTicks) {
  ImperfectHand hand({.delay = 4.4e-3}, kMagnified, kTick);
  const auto path = [](int n) { return at(std::sin(0.3 * n)); };
  for (int n = 0; n < 50; ++n) {
    const double expected = n < 4 ? 0 : std::sin(0.3 * (n - 4));
    EXPECT_NEAR(hand.holder(path(n))[0], expected, 1e-14) << n;
  }
}

// The lag behind a ramp of a first-order system: v tau (1 - exp(-t/tau)); of its sampled form, at
// the end of each tick, v (tau' - T) with tau' = T/(1 - exp(-T/tau)).
TEST(ImperfectHand, SmoothingLagsBehindARamp) {
  const double tau = 20e-3, v = 0.05;
  ImperfectHand hand({.smoothing = tau}, kMagnified, kTick);
  double holder = 0;
  for (int n = 0; n <= 400; ++n) holder = hand.holder(at(v * kTick * n))[0];
  const double followed = -std::expm1(-kTick / tau);
  EXPECT_CLOSE(v * 0.4 - holder, v * kTick * (1 / followed - 1), 1e-6);
  EXPECT_CLOSE(v * 0.4 - holder, v * tau, 0.03);
}

// Speeds at the tip: 2 um/s are 0.5 mm/s of the hand.
TEST(ImperfectHand, TheDeadZoneHoldsWhatIsSlower) {
  ImperfectHand hand({.dead_zone = 2e-6}, kMagnified, kTick);
  hand.holder(at(0));
  EXPECT_EQ(hand.holder(at(0.49e-6, 0, 0.1))[0], 0);    // slower
  EXPECT_EQ(hand.holder(at(0.49e-6, 0, 0.3))[3], 0.3);  // turns as it does
  EXPECT_CLOSE(hand.holder(at(1.49e-6))[0], 1e-6, 1e-12);
}

}  // namespace
}  // namespace ferrule
