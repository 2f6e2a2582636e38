#include "controller/search/hand_response.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace ferrule {
namespace {

constexpr double kToldSpeed = 5e-3, kTick = 1e-3;

// Of a holder that is `way` further [m] a time [s] after it was told to move at kToldSpeed.
ferrule_hand measured(const std::function<double(double)>& way, double duration = 1) {
  ferrule_hand hand;
  ferrule_hand_start(&hand);
  for (int n = 0; n * kTick < duration; ++n)
    ferrule_hand_moved(&hand, way(n * kTick), n * kTick, kToldSpeed);
  return hand;
}

TEST(HandResponse, OfOneThatDoesWhatItIsToldIsNoDelayAndGainOne) {
  const ferrule_hand hand = measured([](double t) { return kToldSpeed * t; });
  EXPECT_TRUE(hand.measured);
  EXPECT_GE(hand.delay, 0);
  EXPECT_LT(hand.delay, 1e-6 * kTick);
  EXPECT_LT(std::abs(hand.gain - 1), 1e-9);
}

TEST(HandResponse, FindsDelayAndGain) {
  for (const double delay : {3e-3, 20e-3, 50e-3})
    for (const double gain : {0.59, 1.0, 1.41}) {
      const ferrule_hand hand =
          measured([&](double t) { return gain * kToldSpeed * std::max(0.0, t - delay); });
      EXPECT_TRUE(hand.measured);
      EXPECT_NEAR(hand.delay, delay, 1e-6 * delay) << gain;
      EXPECT_NEAR(hand.gain, gain, 1e-6 * gain) << delay;
    }
}

// A lag of first order has gone g v (T - tau) once it moves evenly, but for what is left of it in the
// last half of a quarter of a second.
TEST(HandResponse, TakesTheTimeOfALagForADelay) {
  const double tau = 20e-3;
  const ferrule_hand hand =
      measured([&](double t) { return 1.2 * kToldSpeed * (t - tau * (1 - std::exp(-t / tau))); });
  EXPECT_NEAR(hand.delay, tau, 0.06 * tau);
  EXPECT_NEAR(hand.gain, 1.2, 0.02 * 1.2);
}

TEST(HandResponse, TakesItsTimeBeforeItKnows) {
  const auto late = [](double t) { return kToldSpeed * std::max(0.0, t - 0.1); };
  EXPECT_FALSE(measured(late, 0.45).measured);
  EXPECT_EQ(measured(late, 0.45).gain, 1);
  EXPECT_TRUE(measured(late, 0.55).measured);
}

TEST(HandResponse, OfOneThatIsHeldBackIsNoGainThatCouldBe) {
  EXPECT_EQ(measured([](double t) { return 0.1 * kToldSpeed * t; }).gain, 0.5);
  EXPECT_EQ(measured([](double t) { return 9 * kToldSpeed * t; }).gain, 2);
  EXPECT_FALSE(measured([](double) { return 0.0; }).measured);
}

TEST(HandResponse, OfKnownDelayIsNotMeasured) {
  ferrule_hand hand;
  ferrule_hand_known(&hand, 0.17);
  EXPECT_TRUE(hand.measured);
  for (int n = 0; n < 1000; ++n) ferrule_hand_moved(&hand, 1e-3 * n, 1e-3 * n, kToldSpeed);
  EXPECT_EQ(hand.delay, 0.17);
  EXPECT_EQ(hand.gain, 1);
}

}  // namespace
}  // namespace ferrule
