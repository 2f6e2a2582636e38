#include "sim/capillary.hpp"

#include <numbers>

#include "tests/compare.hpp"

namespace ferrule {
namespace {

constexpr Annulus kTableI = {62.5e-6, 63e-6};
constexpr double kDegree = std::numbers::pi / 180;
constexpr Capillary kWater = {Form::printed, 0.072, 60 * kDegree, 80e-9};

TEST(Capillary, PrintedHasThePublishedValuesOfTableI) {
  EXPECT_CLOSE(100e-6 * capillary(kWater, kTableI, 10e-9, true).force, -61.2e-6, 1e-13);
  EXPECT_CLOSE(100e-6 * capillary(kWater, kTableI, 100e-9, true).force, -9.36e-6, 1e-13);
}

TEST(Capillary, PrintedHas30DigitValuesOfOtherParameters) {
  const Capillary epoxy = {Form::printed, 0.045, 20 * kDegree, 130e-9};
  EXPECT_CLOSE(capillary(epoxy, kTableI, 0.5e-9, true).force, -41.330540304914464, 1e-13);
  EXPECT_CLOSE(capillary(epoxy, kTableI, 25e-9, true).force, -0.83160913531005946, 1e-13);
  EXPECT_CLOSE(capillary(epoxy, kTableI, 400e-9, true).force, -0.056757135891607851, 1e-13);
}

TEST(Capillary, ForceAndSlopeAreDerivativesOverDecades) {
  const auto at = [](double h) { return capillary(kWater, kTableI, h, true); };
  for (double h = 0.12e-9; h < 500e-9; h *= 1.7) {
    const double step = 1e-3 * h;
    testing::expect_derivatives(at, h, step, 1e-7);
  }
}

constexpr Capillary kBridge = {Form::corrected, 0.072, 60 * kDegree, 80e-9, 4e-12, 300e-9};

TEST(Capillary, CorrectedHas30DigitValues) {
  const auto at = [](double h) { return capillary(kBridge, kTableI, h, true).force; };
  EXPECT_CLOSE(at(0), -49.792711954231223, 1e-10);
  EXPECT_CLOSE(at(1e-12), -49.792711951361617, 1e-10);
  EXPECT_CLOSE(at(1e-9), -49.789813335289059, 1e-10);
  EXPECT_CLOSE(at(50e-9), -40.370780821344408, 1e-10);
  EXPECT_CLOSE(at(299e-9), -3.1812980542419805, 1e-10);
}

// f = -dw/dh with w = -4 gamma cos(theta) x is an identity of the constant volume.
TEST(Capillary, CorrectedForceIsTheDerivativeOfTheHalfWidth) {
  const auto at = [](double h) { return capillary(kBridge, kTableI, h, true); };
  for (double h = 1e-11; h < 280e-9; h *= 1.9) {
    const double step = std::min(0.4 * h, 1e-3 * (h + 20e-9));
    EXPECT_CLOSE(at(h).force,
                 -testing::derivative([&](double g) { return at(g).potential; }, h, step), 1e-6);
    EXPECT_LT(
        std::abs(at(h).slope - testing::derivative([&](double g) { return at(g).force; }, h, step)),
        1e-6 * std::abs(at(h).slope) + 1e-9 * std::abs(at(h).force) / step);
  }
}

TEST(Capillary, CorrectedFormsAndRupturesAtTwoDistances) {
  EXPECT_EQ(capillary(kBridge, kTableI, 200e-9, false).force, 0);
  EXPECT_LT(capillary(kBridge, kTableI, 200e-9, true).force, 0);
  EXPECT_LT(capillary(kBridge, kTableI, 150e-9, false).force, 0);
  EXPECT_EQ(capillary(kBridge, kTableI, 301e-9, true).force, 0);
  // The potential has no step at either distance.
  for (const auto& [h, bridge] : {std::pair(160e-9, false), {300e-9, true}})
    EXPECT_LT(std::abs(capillary(kBridge, kTableI, h - 1e-15, bridge).potential), 1e-13);
}

}  // namespace
}  // namespace ferrule
