#include "view/browser_device.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "capture/episode.hpp"

namespace ferrule {
namespace {

constexpr double kSpeed = 6e-3, kTick = 1e-3;

// Reads the device from one tick to another, while the page says `v` every 16 ms; silent if empty.
HandSample read_on(BrowserDevice& device, BrowserHand& hand, int from, int to,
                   const std::optional<std::array<double, 3>>& v, std::uint32_t buttons = 0) {
  HandSample sample;
  for (int n = from; n <= to; ++n) {
    if (v && n % 16 == 0) hand.say({*v, buttons, static_cast<std::uint32_t>(n)});
    sample = device.read(n * kTick);
  }
  return sample;
}

TEST(BrowserDevice, DeflectionIsAVelocityUpToTheSpeedOfFullDeflection) {
  for (const std::array<double, 3>& v :
       {std::array<double, 3>{-1, 0, 0}, {0, 0.5, 0}, {0, 0, -0.25}, {-1, 1, 1}}) {
    BrowserHand hand;
    const HandPose start = HandPose::Constant(0.01);
    BrowserDevice device(hand, kSpeed, start);
    const HandPose moved = read_on(device, hand, 0, 1000, v).pose - start;
    const double norm = std::max(1.0, std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]));
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(moved[k], kSpeed * v[static_cast<std::size_t>(k)] / norm, 1e-3 * kSpeed);
    EXPECT_EQ(moved[3], 0);
    EXPECT_LE(moved.head<3>().norm(), kSpeed * (1 + 1e-3));
  }
}

TEST(BrowserDevice, EveryTickMovesByWhatItsCountsSay) {
  BrowserHand hand;
  BrowserDevice device(hand, kSpeed, HandPose::Zero());
  HandSample before;
  for (int n = 0; n < 2000; ++n) {
    if (n % 7 == 0) hand.say({{std::sin(0.01 * n), std::cos(0.02 * n), 0.1}, 0, 0});
    const HandSample now = device.read(n * kTick);
    if (n > 0) {
      const HandTwist rate = device.mapping()->gain * device.mapping()->deflection(before.counts);
      EXPECT_LT((now.pose - before.pose - kTick * rate).norm(), 1e-15);
    }
    before = now;
  }
  EXPECT_GT(before.pose.norm(), 1e-4);
  EXPECT_NE(mapping_text(*device.mapping()).find("velocity"), std::string::npos);
}

TEST(BrowserDevice, ASilentPageStopsTheHandAndASpeakingOneMovesItOn) {
  BrowserHand hand;
  BrowserDevice device(hand, kSpeed, HandPose::Zero());
  EXPECT_LT(read_on(device, hand, 0, 320, {{-1, 0, 0}}).pose[0], -1e-3);  // 320: said last
  const int silent = 320 + static_cast<int>(BrowserDevice::kSilence / kTick) + 2;
  const HandPose soon = read_on(device, hand, 321, silent, {}).pose;
  const HandSample later = read_on(device, hand, silent + 1, 2000, {});
  EXPECT_EQ(later.pose, soon);
  EXPECT_EQ(later.counts, RawCounts::Zero());
  EXPECT_FALSE(later.finished || later.lost);
  EXPECT_LT(read_on(device, hand, 2001, 2300, {{-1, 0, 0}}).pose[0], soon[0]);
}

TEST(BrowserDevice, WhatThePageSaidBeforeDoesNotCount) {
  BrowserHand hand;
  hand.say({{-1, 0, 0}, 1, 5});
  BrowserDevice device(hand, kSpeed, HandPose::Zero());
  const HandSample sample = read_on(device, hand, 0, 50, {});
  EXPECT_EQ(sample.pose, HandPose::Zero());
  EXPECT_FALSE(sample.finished);  // a button that was held at the start
  EXPECT_FALSE(read_on(device, hand, 51, 100, {{0, 0, 0}}, 1).finished);
  EXPECT_FALSE(read_on(device, hand, 101, 130, {{0, 0, 0}}, 0).finished);
  EXPECT_TRUE(read_on(device, hand, 131, 160, {{0, 0, 0}}, 1).finished);
}

TEST(BrowserDevice, SaysWhichMessageItReadLast) {
  BrowserHand hand;
  BrowserDevice device(hand, kSpeed, HandPose::Zero());
  hand.say({{0, 0, 0}, 0, 41});
  device.read(0);
  EXPECT_EQ(device.answered(), 41u);
  hand.say({{0, 0, 0}, 0, 42});
  EXPECT_EQ(device.answered(), 41u);
  device.read(kTick);
  EXPECT_EQ(device.answered(), 42u);
}

TEST(BrowserDevice, WhatIsNoNumberIsNoDeflection) {
  BrowserHand hand;
  hand.say({{NAN, 1, 1}, 0, 1});
  EXPECT_EQ(hand.said().counts, (std::array<std::int16_t, 3>{}));
}

}  // namespace
}  // namespace ferrule
