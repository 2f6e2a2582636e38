#include "sim/van_der_waals.hpp"

#include "tests/compare.hpp"

namespace ferrule {
namespace {

constexpr Annulus kTableI = {62.5e-6, 63e-6};
constexpr VanDerWaals kAluminium = {Form::printed, 3.67e-19};

TEST(VanDerWaals, PrintedHasThePublishedValuesOfTableI) {
  EXPECT_CLOSE(100e-6 * van_der_waals(kAluminium, kTableI, 10e-9).force, -47.786458e-6, 2e-8);
  EXPECT_CLOSE(100e-6 * van_der_waals(kAluminium, kTableI, 100e-9).force, -0.047786458e-6, 2e-8);
}

TEST(VanDerWaals, PrintedHas30DigitValuesOfOtherParameters) {
  const Annulus annulus = {40e-6, 41e-6};
  const VanDerWaals law = {Form::printed, 1.1e-19};
  EXPECT_CLOSE(van_der_waals(law, annulus, 0.5e-9).force, -733.33333333333333, 1e-13);
  EXPECT_CLOSE(van_der_waals(law, annulus, 3e-9).force, -3.3950617283950617, 1e-13);
  EXPECT_CLOSE(van_der_waals(law, annulus, 25e-9).force, -0.0058666666666666667, 1e-13);
  EXPECT_CLOSE(van_der_waals(law, annulus, 99e-9).force, -9.4472597278433418e-5, 1e-13);
}

TEST(VanDerWaals, ForceAndSlopeAreDerivativesOverDecades) {
  for (double h = 0.12e-9; h < 99e-9; h *= 1.7) {
    const LineForce f = van_der_waals(kAluminium, kTableI, h);
    const auto potential = [](double g) { return van_der_waals(kAluminium, kTableI, g).potential; };
    const auto force = [](double g) { return van_der_waals(kAluminium, kTableI, g).force; };
    const double step = 1e-3 * h;
    EXPECT_CLOSE(f.force, -testing::derivative(potential, h, step), 1e-7) << h;
    EXPECT_CLOSE(f.slope, testing::derivative(force, h, step), 1e-7) << h;
  }
  // In the taper and in the last a_0.
  for (const double h : {100.2e-9, 100.7e-9, 0.03e-9, 0.07e-9}) {
    const auto potential = [](double g) { return van_der_waals(kAluminium, kTableI, g).potential; };
    const auto force = [](double g) { return van_der_waals(kAluminium, kTableI, g).force; };
    const LineForce f = van_der_waals(kAluminium, kTableI, h);
    EXPECT_CLOSE(f.force, -testing::derivative(potential, h, 1e-12), 1e-6) << h;
    EXPECT_CLOSE(f.slope, testing::derivative(force, h, 1e-12), 1e-6) << h;
  }
}

TEST(VanDerWaals, PrintedIsContinuousAtTheEndsOfItsRangeAndZeroBeyond) {
  for (const double end : {0.0, 0.1e-9, 100e-9, 101e-9}) {
    const LineForce below = van_der_waals(kAluminium, kTableI, end - 1e-18);
    const LineForce above = van_der_waals(kAluminium, kTableI, end + 1e-18);
    const double at_a0 = std::abs(van_der_waals(kAluminium, kTableI, 0.1e-9).force);
    EXPECT_LT(std::abs(below.force - above.force), 1e-6 * at_a0);
    EXPECT_LE(std::abs(below.potential - above.potential), 1e-7 * std::abs(below.potential));
  }
  EXPECT_EQ(van_der_waals(kAluminium, kTableI, 150e-9).force, 0);
  EXPECT_EQ(van_der_waals(kAluminium, kTableI, -5e-9).force, 0);
}

}  // namespace
}  // namespace ferrule
