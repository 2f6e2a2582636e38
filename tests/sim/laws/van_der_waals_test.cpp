#include "sim/laws/van_der_waals.hpp"

#include "sim/laws/paper/van_der_waals.hpp"
#include "tests/compare.hpp"
#include "tests/sim/laws/annulus.hpp"

namespace ferrule {
namespace {

constexpr printed::VanDerWaals kAluminium = {3.67e-19};

TEST(VanDerWaals, PrintedHasThePublishedValuesOfTableI) {
  EXPECT_CLOSE(100e-6 * van_der_waals(kAluminium, kAnnulus, 10e-9).force, -47.786458e-6, 2e-8);
  EXPECT_CLOSE(100e-6 * van_der_waals(kAluminium, kAnnulus, 100e-9).force, -0.047786458e-6, 2e-8);
}

TEST(VanDerWaals, PrintedHas30DigitValuesOfOtherParameters) {
  const Annulus annulus = {40e-6, 41e-6};
  const printed::VanDerWaals law = {1.1e-19};
  EXPECT_CLOSE(van_der_waals(law, annulus, 0.5e-9).force, -733.33333333333333, 1e-13);
  EXPECT_CLOSE(van_der_waals(law, annulus, 3e-9).force, -3.3950617283950617, 1e-13);
  EXPECT_CLOSE(van_der_waals(law, annulus, 25e-9).force, -0.0058666666666666667, 1e-13);
  EXPECT_CLOSE(van_der_waals(law, annulus, 99e-9).force, -9.4472597278433418e-5, 1e-13);
}

TEST(VanDerWaals, ForceAndSlopeAreDerivativesOverDecades) {
  const auto at = [](double h) { return van_der_waals(kAluminium, kAnnulus, h); };
  for (double h = 0.12e-9; h < 99e-9; h *= 1.7) testing::expect_derivatives(at, h, 1e-3 * h, 1e-7);
  // In the taper and in the last a_0.
  for (const double h : {100.2e-9, 100.7e-9}) testing::expect_derivatives(at, h, 1e-12, 1e-6);
  for (const double h : {0.03e-9, 0.07e-9}) testing::expect_derivatives(at, h, 1e-4 * h, 1e-6);
}

TEST(VanDerWaals, PrintedIsContinuousAtTheEndsOfItsRangeAndZeroBeyond) {
  for (const double end : {0.0, 0.1e-9, 100e-9, 101e-9}) {
    const LineForce below = van_der_waals(kAluminium, kAnnulus, end - 1e-18);
    const LineForce above = van_der_waals(kAluminium, kAnnulus, end + 1e-18);
    const double at_a0 = std::abs(van_der_waals(kAluminium, kAnnulus, 0.1e-9).force);
    EXPECT_LT(std::abs(below.force - above.force), 1e-6 * at_a0);
    EXPECT_LE(std::abs(below.potential - above.potential), 1e-7 * std::abs(below.potential));
  }
  EXPECT_EQ(van_der_waals(kAluminium, kAnnulus, 150e-9).force, 0);
  EXPECT_EQ(van_der_waals(kAluminium, kAnnulus, -5e-9).force, 0);
}

constexpr VanDerWaals kCorrected = {3.67e-19};

TEST(VanDerWaals, CorrectedHasThePublishedValues) {
  const auto uN = [](double h) {
    return 1e6 * 100e-6 * van_der_waals(kCorrected, kAnnulus, h).force;
  };
  EXPECT_CLOSE(uN(1e-9), -9071.370714, 1e-9);
  EXPECT_CLOSE(uN(10e-9), -28.81337847, 1e-9);
  EXPECT_CLOSE(uN(100e-9), -0.09439300412, 1e-9);
  EXPECT_CLOSE(uN(450e-9), -0.0009408450112, 1e-8);
}

// Relative to c, e and h are only known to the rounding of r and R: 1e-16 r/c; hence 1e-10.
TEST(VanDerWaals, CorrectedHas30DigitValuesNearContactAndNearTheAxis) {
  const auto at = [](double h, double roughness) {
    return van_der_waals(kCorrected, {62.5e-6, 63e-6, roughness}, h).force;
  };
  EXPECT_CLOSE(at(0, 5e-9), -1.61784646067118772, 1e-10);
  EXPECT_CLOSE(at(1e-13, 1e-9), -90.600391814722613, 1e-10);
  EXPECT_CLOSE(at(499.9995e-9, 2e-9), -9.0296563377074e-11, 1e-6) << "e = 0.5 pm";
}

TEST(VanDerWaals, CorrectedForceAndSlopeAreDerivativesOverDecades) {
  const Annulus rough = {62.5e-6, 63e-6, 2e-9};
  const auto at = [&](double h) { return van_der_waals(kCorrected, rough, h); };
  for (double h = 1e-11; h < 480e-9; h *= 1.9) {
    const double step = 1e-3 * (h + 2e-9) * (h > 1e-10 ? 1 : 1e-3);
    testing::expect_derivatives(at, h, step, 1e-6);
  }
  // Pressed together: linear down to nothing where the mean planes meet, and pushing beyond.
  EXPECT_CLOSE(at(-1e-9).force, 0.5 * at(0).force, 1e-12);
  EXPECT_LE(std::abs(at(-2e-9).force), 1e-12 * std::abs(at(0).force));
  EXPECT_CLOSE(at(-4e-9).force, -at(0).force, 1e-12);
  EXPECT_CLOSE(at(-3e-9).slope, at(0).force / 2e-9, 1e-12);
  EXPECT_CLOSE(at(-3e-9).potential - at(0).potential, 0.75e-9 * at(0).force, 1e-6);
}

TEST(VanDerWaals, CorrectedTendsToTheHalfSpacesOfDerjaguinNearContact) {
  // Force between a cylinder in a cylinder near contact, R_e = r R/c: integral over the parabola.
  const double h = 1e-9, radius = 62.5e-6 * 63e-6 / 0.5e-6;
  const double expected = -3.67e-19 * std::sqrt(2 * radius) / (16 * std::pow(h, 2.5));
  EXPECT_CLOSE(van_der_waals(kCorrected, kAnnulus, h).force, expected, 2e-2);
}

}  // namespace
}  // namespace ferrule
