#include "haptic/force_guard.hpp"

#include "sim/base/random.hpp"
#include "tests/compare.hpp"
#include "tests/haptic/sample_period.hpp"

namespace ferrule {
namespace {

using Stage = ForceGuard::Stage;

HandWrench pull(double x, double y = 0, double moment = 0) {
  HandWrench w = HandWrench::Zero();
  w[0] = x;
  w[1] = y;
  w[3] = moment;
  return w;
}

// A guard with its own time, and a hand that rests unless it is moved.
struct Guarded {
  ForceGuard guard{GuardSettings{.max_force = 8}};
  double time = 0, sampled_at = 0;
  HandPose hand = HandPose::Zero();

  HandWrench pass(const HandWrench& wanted, bool fresh = true) {
    time += T;
    if (fresh) sampled_at = time;
    return guard.pass(time, sampled_at, hand, wanted);
  }
  void engage() {
    while (guard.stage() != Stage::engaged) pass(pull(0.1));
  }
};

TEST(ForceGuard, GivesNothingUntilTheForceWasSmallForSomePeriods) {
  Guarded g;
  for (int n = 0; n < 1000; ++n) EXPECT_EQ(g.pass(pull(3)).norm(), 0);
  for (int round = 0; round < 10; ++round) {  // never five in a row
    for (int n = 0; n < 4; ++n) EXPECT_EQ(g.pass(pull(0.19)).norm(), 0);
    EXPECT_EQ(g.pass(pull(0.21)).norm(), 0);
  }
  EXPECT_EQ(g.guard.stage(), Stage::waiting);
  for (int n = 0; n < 5; ++n) g.pass(pull(0.19));
  EXPECT_EQ(g.guard.stage(), Stage::ramping);
}

TEST(ForceGuard, RampsOverTwoSeconds) {
  Guarded g;
  while (g.guard.stage() == Stage::waiting) g.pass(pull(0));
  for (int n = 1; n <= 2500; ++n) {
    const HandWrench out = g.pass(pull(3, -1, 0.2));
    const double factor = std::min(1.0, n * T / 2);
    EXPECT_LT((out - factor * pull(3, -1, 0.2)).norm(), 1e-9) << n;
  }
  EXPECT_EQ(g.guard.stage(), Stage::engaged);
}

TEST(ForceGuard, RampsAgainWhereTheDeviceLetGo) {
  Guarded g;
  g.guard.ramp_again(g.time);
  EXPECT_EQ(g.guard.stage(), Stage::waiting);
  g.engage();
  EXPECT_EQ(g.pass(pull(3)), pull(3));
  g.guard.ramp_again(g.time);
  for (int n = 1; n <= 2500; ++n)
    EXPECT_LT((g.pass(pull(3)) - std::min(1.0, n * T / 2) * pull(3)).norm(), 1e-9) << n;
  EXPECT_EQ(g.guard.stage(), Stage::engaged);
}

TEST(ForceGuard, HoldsTheForceAtTheDevicesLimitInItsDirection) {
  Guarded g;
  g.engage();
  for (const double size : {1.0, 7.9, 8.1, 1e3, 1e12}) {
    const HandWrench out = g.pass(pull(0.6 * size, -0.8 * size, 0.1 * size));
    EXPECT_CLOSE(out.head<3>().norm(), std::min(8.0, size), 1e-12);
    EXPECT_CLOSE(out[0] / out[1], -0.75, 1e-12);
    EXPECT_CLOSE(out[3] / out[0], 1 / 6.0, 1e-12);
  }
}

TEST(ForceGuard, WhatIsNotFiniteGivesNoForceAtOnce) {
  for (const double bad : {double(NAN), double(INFINITY), -double(INFINITY)})
    for (int place = 0; place < 10; ++place) {
      Guarded g;
      g.engage();
      HandWrench wanted = pull(3);
      (place < 5 ? wanted[place] : g.hand[place - 5]) = bad;
      EXPECT_EQ(g.pass(wanted).norm(), 0) << place << " " << bad;
      EXPECT_EQ(g.guard.stage(), Stage::waiting);
    }
  Guarded g;
  g.engage();
  EXPECT_EQ(g.guard.pass(NAN, g.sampled_at, g.hand, pull(3)).norm(), 0);
  g.engage();
  EXPECT_EQ(g.guard.pass(g.time, NAN, g.hand, pull(3)).norm(), 0);
}

TEST(ForceGuard, StaleDataEndTheForceWithinTwoPeriods) {
  Guarded g;
  g.engage();
  EXPECT_GT(g.pass(pull(3)).norm(), 0);
  EXPECT_GT(g.pass(pull(3), false).norm(), 0) << "one sample late is no reason yet";
  for (int n = 0; n < 100; ++n) EXPECT_EQ(g.pass(pull(3), false).norm(), 0);
  EXPECT_EQ(g.pass(pull(3)).norm(), 0) << "and it begins from the start";
}

TEST(ForceGuard, AJumpOfTheHandEndsTheForceAtOnce) {
  for (const int axis : {0, 1, 2}) {
    Guarded g;
    g.engage();
    for (int n = 0; n < 100; ++n) {  // fast, but a hand's
      g.hand[axis] += 1.9 * T;
      EXPECT_GT(g.pass(pull(3)).norm(), 0);
    }
    g.hand[axis] += 2.1 * T;
    EXPECT_EQ(g.pass(pull(3)).norm(), 0);
    EXPECT_EQ(g.pass(pull(3)).norm(), 0);
    g.engage();
  }
}

TEST(ForceGuard, NeverMoreThanTheLimitWhateverComes) {
  RandomStream random(5, 0, Draw::start);
  Guarded g;
  for (int n = 0; n < 200000; ++n) {
    const double what = random.uniform();
    const double size = std::pow(10, 12 * random.uniform() - 6);
    HandWrench wanted = pull(0.05 * random.uniform());
    if (what < 0.3) wanted = size * pull(random.uniform() - 0.5, random.uniform() - 0.5);
    if (what < 1e-4) wanted[1] = NAN;
    if (what > 0.9998) g.hand[0] += 1;
    const HandWrench out = g.pass(wanted, random.uniform() > 0.01);
    ASSERT_TRUE(out.allFinite());
    ASSERT_LE(out.head<3>().norm(), 8 * (1 + 1e-12));
    if (wanted.allFinite())
      ASSERT_LE(out.head<3>().norm(), wanted.head<3>().norm() * (1 + 1e-12));
    else
      ASSERT_EQ(out.norm(), 0);
  }
}

}  // namespace
}  // namespace ferrule
