#include "haptic/force_feedback.hpp"

#include "tests/compare.hpp"
#include "tests/haptic/sample_period.hpp"

namespace ferrule {
namespace {

HandWrench along_y(double force) {
  HandWrench w = HandWrench::Zero();
  w[1] = force;
  return w;
}

// A loop at rest that has its force, in front of a fibre.
struct Loop {
  DeviceProfile device = load_device_profile("pen");
  HandPose start = HandPose::Constant(0.01);
  ForceFeedback feedback;
  HandPose hand = start;
  double time = 0;

  explicit Loop(const std::optional<Coupling>& coupling = {}, double report_period = 0)
      : feedback(device, coupling, start, report_period) {
    while (feedback.stage() != ForceGuard::Stage::engaged)
      period([](const HandPose&) { return 0; });
  }

  // One period against a fibre whose force along y follows from where its holder is.
  template <typename Fibre>
  HandWrench period(const Fibre& fibre, double stiffness = 0, double age = 0) {
    const HandPose holder = feedback.hold(hand, stiffness * Eigen::Matrix3d::Identity());
    time += T;
    const HandWrench wrench = along_y(fibre(holder));
    return feedback.feel(time, age, wrench, wrench);
  }
};

TEST(ForceFeedback, TheFibreIsFeltUpToTheDevicesLargestForce) {
  Loop loop;
  EXPECT_FALSE(loop.feedback.coupled());
  EXPECT_EQ(loop.period([](const HandPose&) { return 0; }).norm(), 0);
  EXPECT_CLOSE(loop.period([](const HandPose&) { return 3; })[1], 3, 1e-12);
  EXPECT_CLOSE(loop.period([](const HandPose&) { return -100; })[1], -loop.device.max_force, 1e-12);
  EXPECT_EQ(loop.feedback.fault(), nullptr);
}

TEST(ForceFeedback, WithoutACouplingTheHandIsTheHolder) {
  Loop loop;
  loop.hand[2] += 1e-4;
  loop.hand[3] -= 1e-3;
  EXPECT_EQ(loop.feedback.hold(loop.hand, Eigen::Matrix3d::Identity()), loop.hand);
}

// Against a spring k the hand comes to feel k in series with the coupling, whatever k.
TEST(ForceFeedback, ThroughACouplingNothingFeelsStifferThanIt) {
  const Coupling coupling = stable_coupling(load_device_profile("pen"));
  for (const double k : {1.0, 1e3, 1e6}) {
    Loop loop(coupling);
    const double pushed = 1e-3, begin = loop.start[1];
    HandWrench felt;
    for (int n = 0; n < 4000; ++n) {
      if (n < 100) loop.hand[1] -= pushed / 100;
      felt = loop.period([&](const HandPose& holder) { return -k * (holder[1] - begin); }, k);
    }
    EXPECT_CLOSE(felt[1], pushed * k * coupling.stiffness / (k + coupling.stiffness), 1e-6) << k;
    EXPECT_EQ(loop.feedback.fault(), nullptr);
  }
}

// The bias of the sensor, 3 N, is taken off; what its errors are beyond that is felt, and does not
// move a holder.
TEST(ForceFeedback, TheSensorsBiasIsTakenOffAndItsNoiseFelt) {
  const DeviceProfile pen = load_device_profile("pen");
  for (const bool coupled : {false, true}) {
    ForceFeedback feedback(pen, coupled ? std::optional(stable_coupling(pen)) : std::nullopt,
                           HandPose::Zero(), 0);
    const HandWrench fibre = HandWrench::Zero();
    HandWrench felt;
    for (int n = 1; n <= 4000; ++n) {
      const double noise = n % 2 ? 0.05 : -0.05;
      EXPECT_EQ(feedback.hold(HandPose::Zero(), Eigen::Matrix3d::Zero()), HandPose::Zero());
      felt = feedback.feel(n * T, 0, fibre, fibre + along_y(3 + noise));
      if (n <= ForceFeedback::kTare) {
        EXPECT_EQ(felt.norm(), 0);
      }
    }
    EXPECT_CLOSE(felt[1], -0.05, 1e-9);
  }
}

// A stick without a motor along z: what is pressed there takes no energy from the hand, and covers
// none of what the force along y gives out.
TEST(ForceFeedback, WhatHasNoMotorIsNotFeltAndHoldsNoEnergy) {
  for (const bool motor : {true, false}) {
    ForceFeedback feedback(load_device_profile("pen"), {}, HandPose::Zero(), 0,
                           {1, 1, motor ? 1.0 : 0.0});
    HandPose hand = HandPose::Zero();
    HandWrench wrench = HandWrench::Zero(), felt;
    const auto period = [&](int n) {
      feedback.hold(hand, Eigen::Matrix3d::Zero());
      felt = feedback.feel(n * T, 0, wrench, wrench);
    };
    int n = 0;
    while (feedback.stage() != ForceGuard::Stage::engaged) period(++n);
    wrench[2] = -2;
    for (int i = 0; i < 100; ++i, period(++n)) hand[2] += 5e-5;
    EXPECT_CLOSE(felt[2], motor ? -2 : 0, 1e-12);
    wrench[2] = 0;
    wrench[1] = 2;
    for (int i = 0; i < 100; ++i, period(++n)) hand[1] += 1e-5;
    EXPECT_EQ(felt[1] == 2, motor) << felt[1];
    EXPECT_EQ(feedback.fault(), nullptr);
  }
}

// Whatever cannot be trusted: no force in the same period, and none after it.
TEST(ForceFeedback, AFaultTakesTheForceAwayForGood) {
  const auto three = [](const HandPose&) { return 3.0; };
  const auto expect_fault = [&](Loop& loop, const HandWrench& felt, const std::string& what) {
    EXPECT_EQ(felt.norm(), 0) << what;
    ASSERT_NE(loop.feedback.fault(), nullptr) << what;
    EXPECT_NE(std::string(loop.feedback.fault()).find(what), std::string::npos)
        << loop.feedback.fault();
    loop.hand = loop.start;
    for (int n = 0; n < 5000; ++n)
      EXPECT_EQ(loop.period([](const HandPose&) { return 0.1; }).norm(), 0);
  };
  for (const bool coupled : {false, true}) {
    std::optional<Coupling> coupling;
    if (coupled) coupling = stable_coupling(load_device_profile("pen"));
    {
      Loop loop(coupling);
      loop.hand[4] = NAN;
      const HandPose held = loop.feedback.hold(loop.hand, Eigen::Matrix3d::Zero());
      EXPECT_TRUE(held.allFinite());
      expect_fault(loop, loop.period(three), "position is not a finite number");
    }
    {
      Loop loop(coupling);
      const HandWrench felt = loop.period([](const HandPose&) { return INFINITY; });
      expect_fault(loop, felt, "not a finite number");
    }
    {
      Loop loop(coupling);
      loop.hand[4] += 0.03;
      expect_fault(loop, loop.period(three), "jumped");
    }
    {
      Loop loop(coupling);
      loop.hand[0] += 0.01;
      expect_fault(loop, loop.period(three), "jumped");
    }
    {
      Loop loop(coupling);
      EXPECT_EQ(loop.feedback.fault(), nullptr);
      loop.period(three, 0, 0.9 * T);
      EXPECT_EQ(loop.feedback.fault(), nullptr);
      expect_fault(loop, loop.period(three, 0, 1.9 * T), "too old");
    }
  }
}

// A hand is judged before the fibre follows it, and feeling it afterwards changes nothing.
TEST(ForceFeedback, AHandThatJumpedIsSeenBeforeTheStep) {
  for (const double jump : {-0.01, 0.1, 1.0, 1e300, double(NAN)}) {
    Loop loop;
    EXPECT_TRUE(loop.feedback.trusts(loop.time + T, 0, loop.hand));
    loop.hand[0] += jump;
    EXPECT_FALSE(loop.feedback.trusts(loop.time + T, 0, loop.hand)) << jump;
    EXPECT_NE(loop.feedback.fault(), nullptr);
    loop.hand = loop.start;
    for (int n = 0; n < 5000; ++n)
      EXPECT_EQ(loop.period([](const HandPose&) { return 0.1; }).norm(), 0);
  }
  Loop old;
  EXPECT_FALSE(old.feedback.trusts(old.time + T, 1.6 * T, old.hand));
}

// A hand at 0.5 m/s, told of every 8 ms: 4 mm at once, and no jump.
TEST(ForceFeedback, AReportThatComesEveryFewPeriodsIsNoJump) {
  Loop slow({}, 0.016), fast;
  const auto three = [](const HandPose&) { return 3.0; };
  for (int n = 1; n <= 800; ++n) {
    if (n % 8 == 0) slow.hand[1] += 4e-3;
    slow.period(three);
    ASSERT_EQ(slow.feedback.fault(), nullptr) << n;
  }
  fast.hand[1] += 4e-3;
  fast.period(three);
  EXPECT_NE(fast.feedback.fault(), nullptr);
  for (int n = 0; n < 1000; ++n) slow.period(three);  // a long rest allows no longer jump
  slow.hand[1] += 0.033;
  slow.period(three);
  EXPECT_NE(slow.feedback.fault(), nullptr);
}

}  // namespace
}  // namespace ferrule
