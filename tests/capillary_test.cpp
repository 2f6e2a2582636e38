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
    EXPECT_CLOSE(at(h).force,
                 -testing::derivative([&](double g) { return at(g).potential; }, h, step), 1e-7);
    EXPECT_CLOSE(at(h).slope, testing::derivative([&](double g) { return at(g).force; }, h, step),
                 1e-7);
  }
}

}  // namespace
}  // namespace ferrule
