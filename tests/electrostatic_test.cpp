#include "sim/electrostatic.hpp"

#include "tests/compare.hpp"

namespace ferrule {
namespace {

constexpr Annulus kTableI = {62.5e-6, 63e-6};
constexpr Electrostatic kTenthVolt = {Form::printed, 0.1};

TEST(Electrostatic, PrintedHasThePublishedValuesOfTableI) {
  EXPECT_CLOSE(100e-6 * electrostatic(kTenthVolt, kTableI, 10e-9).force, -4.3442336e-6, 2e-8);
  EXPECT_CLOSE(100e-6 * electrostatic(kTenthVolt, kTableI, 100e-9).force, -0.043442336e-6, 2e-8);
}

TEST(Electrostatic, PrintedHas30DigitValuesOfOtherParameters) {
  const Annulus annulus = {40e-6, 41e-6};
  const Electrostatic law = {Form::printed, 0.7};
  EXPECT_CLOSE(electrostatic(law, annulus, 0.5e-9).force, -544.94066169168554, 1e-13);
  EXPECT_CLOSE(electrostatic(law, annulus, 25e-9).force, -0.21797626467667421, 1e-13);
  EXPECT_CLOSE(electrostatic(law, annulus, 400e-9).force, -8.5146978389325865e-4, 1e-13);
}

TEST(Electrostatic, ForceAndSlopeAreDerivativesOverDecades) {
  const auto at = [](double h) { return electrostatic(kTenthVolt, kTableI, h); };
  for (double h = 0.12e-9; h < 500e-9; h *= 1.7) {
    const double step = 1e-3 * h;
    EXPECT_CLOSE(at(h).force,
                 -testing::derivative([&](double g) { return at(g).potential; }, h, step), 1e-7);
    EXPECT_CLOSE(at(h).slope, testing::derivative([&](double g) { return at(g).force; }, h, step),
                 1e-7);
  }
}

TEST(Electrostatic, GrowsWithTheSquareOfTheVoltage) {
  EXPECT_CLOSE(electrostatic({Form::printed, 0.3}, kTableI, 20e-9).force,
               9 * electrostatic(kTenthVolt, kTableI, 20e-9).force, 1e-14);
  EXPECT_EQ(electrostatic({Form::printed, 0}, kTableI, 20e-9).force, 0);
}

}  // namespace
}  // namespace ferrule
