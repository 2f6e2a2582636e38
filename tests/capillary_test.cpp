#include "sim/capillary.hpp"

#include <numbers>

#include "sim/surface_forces.hpp"
#include "tests/compare.hpp"
#include "tests/scenes.hpp"

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

// Along a tilted fibre the force goes over into that of parallel axes, off the bore's axis exactly.
TEST(Capillary, ForceIsContinuousInTheTilt) {
  const World world =
      testing::paper({"roughness_nm=5", "laws.van_der_waals=null", "laws.electrostatic=null",
                      "laws.capillary.form=corrected", "laws.capillary.rupture_nm=2000"})
          .world;
  const double c = world.annulus.clearance(), length = 100e-6;
  const auto pull = [&](double gap, double tilt) {
    Pose tip;
    tip << -length, gap - c, 0, tilt, 0;
    Energy energy;
    SurfaceGradients terms;
    add_surface_forces(energy, terms, world, length, true, tip);
    return -terms[kCapillary].e.x();
  };
  for (double gap = 1e-9; gap < 0.99 * c && gap < world.capillary->rupture; gap *= 1.3) {
    const double parallel = length * capillary(*world.capillary, world.annulus, gap, true).force;
    EXPECT_CLOSE(pull(gap, 0), parallel, 1e-12) << gap;
    for (const double tilt : {1e-12, -1e-12, 1e-10, -1e-10})
      EXPECT_CLOSE(pull(gap, tilt), parallel, 1e-12 + 2 * std::abs(tilt) * length / gap) << gap;
  }
  // Across the axis too, where the direction turns.
  double before = pull(c - 5e-9, 0);
  for (double gap = c - 5e-9; gap < c + 5e-9; gap += 1e-12) {
    const double now = pull(gap, 1e-12);
    EXPECT_LT(std::abs(now - before), 0.01 * std::abs(pull(c - 5e-9, 0))) << gap;
    before = now;
  }
}

}  // namespace
}  // namespace ferrule
