#include "sim/laws/electrostatic.hpp"

#include "sim/laws/paper/electrostatic.hpp"
#include "tests/compare.hpp"
#include "tests/sim/laws/annulus.hpp"

namespace ferrule {
namespace {

constexpr printed::Electrostatic kTenthVolt = {0.1};

TEST(Electrostatic, PrintedHasThePublishedValuesOfTableI) {
  EXPECT_CLOSE(100e-6 * electrostatic(kTenthVolt, kAnnulus, 10e-9).force, -4.3442336e-6, 2e-8);
  EXPECT_CLOSE(100e-6 * electrostatic(kTenthVolt, kAnnulus, 100e-9).force, -0.043442336e-6, 2e-8);
}

TEST(Electrostatic, PrintedHas30DigitValuesOfOtherParameters) {
  const Annulus annulus = {40e-6, 41e-6};
  const printed::Electrostatic law = {0.7};
  EXPECT_CLOSE(electrostatic(law, annulus, 0.5e-9).force, -544.94066169168554, 1e-13);
  EXPECT_CLOSE(electrostatic(law, annulus, 25e-9).force, -0.21797626467667421, 1e-13);
  EXPECT_CLOSE(electrostatic(law, annulus, 400e-9).force, -8.5146978389325865e-4, 1e-13);
}

TEST(Electrostatic, ForceAndSlopeAreDerivativesOverDecades) {
  const auto at = [](double h) { return electrostatic(kTenthVolt, kAnnulus, h); };
  for (double h = 0.12e-9; h < 500e-9; h *= 1.7) {
    const double step = 1e-3 * h;
    testing::expect_derivatives(at, h, step, 1e-7);
  }
}

TEST(Electrostatic, GrowsWithTheSquareOfTheVoltage) {
  EXPECT_CLOSE(printed::electrostatic({0.3}, kAnnulus, 20e-9).force,
               9 * electrostatic(kTenthVolt, kAnnulus, 20e-9).force, 1e-14);
  EXPECT_EQ(printed::electrostatic({0}, kAnnulus, 20e-9).force, 0);
}

constexpr Electrostatic kCharged = {0.1};

TEST(Electrostatic, CorrectedHasThePublishedValues) {
  const auto uN = [](double h) {
    return 1e6 * 100e-6 * electrostatic(kCharged, kAnnulus, h).force;
  };
  EXPECT_CLOSE(uN(1e-9), -27.58425092, 1e-9);
  EXPECT_CLOSE(uN(10e-9), -0.8682646677, 1e-9);
  EXPECT_CLOSE(uN(100e-9), -0.02585858162, 1e-9);
  EXPECT_CLOSE(uN(450e-9), -0.0007087857017, 1e-8);
}

TEST(Electrostatic, CorrectedHas30DigitValuesNearContactAndNearTheAxis) {
  const auto at = [](double h, double roughness) {
    return electrostatic(kCharged, {62.5e-6, 63e-6, roughness}, h).force;
  };
  EXPECT_CLOSE(at(1e-9, 5e-9), -0.018629413924989262, 1e-10);
  EXPECT_CLOSE(at(0.5e-15, 1e-9), -0.27556933641191384, 1e-10);
  EXPECT_CLOSE(at(499.9995e-9, 2e-9), -6.8987987221147745e-11, 1e-6) << "e = 0.5 pm";
}

TEST(Electrostatic, CorrectedForceAndSlopeAreDerivativesOverDecades) {
  const Annulus rough = {62.5e-6, 63e-6, 2e-9};
  const auto at = [&](double h) { return electrostatic(kCharged, rough, h); };
  for (double h = 1e-10; h < 480e-9; h *= 1.9) {
    const double step = 1e-3 * (h + 2e-9) * (h > 1e-9 ? 1 : 1e-2);
    testing::expect_derivatives(at, h, step, 1e-6);
  }
}

}  // namespace
}  // namespace ferrule
