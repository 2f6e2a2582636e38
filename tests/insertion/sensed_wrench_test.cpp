#include "insertion/sensed_wrench.hpp"

#include "insertion/scene_scaling.hpp"
#include "tests/compare.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

constexpr double kPeriod = 1e-3;

Wrench force(double x, double y, double z) {
  return (Wrench() << x, y, z, 0, 0).finished();
}

// A sensor whose bias is what its reading jumps to after the tare.
SensedWrench biased(const Tare& tare) {
  return {{1, 1}, ForceSensor({.bias = 1e-6}, 1, 1), kPeriod, tare};
}

TEST(SensedWrench, WithoutTareABiasIsTakenForAForce) {
  SensedWrench sensed = biased({});
  for (int n = 0; n < 100; ++n) sensed.read(Wrench::Zero(), 1);
  EXPECT_GT(sensed.relative().norm(), 1e-7);
}

TEST(SensedWrench, TaredInFreeAirReadsTheForceWithoutTheBias) {
  SensedWrench sensed = biased({.time = 0.1, .free_beyond = 0});
  for (int n = 0; n < 100; ++n) {
    sensed.read(Wrench::Zero(), 1e-5);
    EXPECT_EQ(sensed.relative(), HandWrench(HandWrench::Zero()));
  }
  sensed.read(Wrench::Zero(), -1e-6);
  EXPECT_LT(sensed.relative().norm(), 1e-12);
  sensed.read(force(3e-6, 0, -4e-6), -1e-6);
  EXPECT_LT((sensed.relative() - force(3e-6, 0, -4e-6)).norm(), 1e-12);
}

TEST(SensedWrench, BeginsInFreeAirWithinTheLeadInToo) {
  SensedWrench sensed = biased({.time = 0.1, .free_beyond = 1e-4});
  for (int n = 0; n < 100; ++n) {
    sensed.read(Wrench::Zero(), 5e-5);
    EXPECT_EQ(sensed.relative(), HandWrench(HandWrench::Zero()));
  }
  sensed.read(force(3e-6, 0, -4e-6), 5e-5);
  EXPECT_LT((sensed.relative() - force(3e-6, 0, -4e-6)).norm(), 1e-12);
}

// The mean of many readings: noise of one over the root of their number.
TEST(SensedWrench, TheTareIsAMean) {
  double squares = 0;
  const int trials = 300;
  for (int trial = 0; trial < trials; ++trial) {
    SensedWrench sensed({1, 1}, ForceSensor({.noise = 1e-6}, 2, static_cast<std::uint64_t>(trial)),
                        kPeriod, {.time = 0.4, .free_beyond = 0});
    for (int n = 0; n < 401; ++n) sensed.read(Wrench::Zero(), 1e-5);
    sensed.read(Wrench::Zero(), -1e-6);
    squares += sensed.relative()[1] * sensed.relative()[1] / trials;
  }
  EXPECT_CLOSE(squares, 1e-12 * (1 + 1.0 / 400), 0.3);
}

TEST(SensedWrench, ADeadBandTakesItselfOffTheForceAndTurnsWithIt) {
  SensedWrench sensed({2, 10}, ForceSensor(), kPeriod, {.dead_band = 1e-6, .arm = 0.01});
  sensed.read(Wrench::Zero(), 0);
  sensed.read(force(0.5e-6, 0.5e-6, -0.5e-6), 0);
  EXPECT_EQ(sensed.relative(), HandWrench(HandWrench::Zero()));
  sensed.read(force(3e-6, 0, -4e-6), 0);
  EXPECT_LT((sensed.relative() - 10 * 0.8 * force(3e-6, 0, -4e-6)).norm(), 1e-15);
  sensed.read((Wrench() << 0, 0, 0, 3e-8, 4e-8).finished(), 0);
  EXPECT_LT((sensed.relative() - 20 * 0.8 * (Wrench() << 0, 0, 0, 3e-8, 4e-8).finished()).norm(),
            1e-15);
}

TEST(SensedWrench, FreeAirIsBeforeTheLeadInOrTheFace) {
  const Scene cone = testing::paper(), sharp = testing::bare();
  EXPECT_CLOSE(scene_tare(cone).free_beyond, 62e-6 / std::tan(std::numbers::pi / 6) + 2e-6, 1e-9);
  EXPECT_CLOSE(scene_tare(sharp).free_beyond, 2e-6, 1e-9);
  EXPECT_EQ(scene_tare(cone).time, 0);
}

}  // namespace
}  // namespace ferrule
