#include "sim/laws/drag.hpp"

#include <numbers>

#include "sim/solver/step.hpp"
#include "tests/compare.hpp"
#include "tests/scenes.hpp"
#include "tests/sim/laws/annulus.hpp"

namespace ferrule {
namespace {

TEST(Drag, OfAThickAdhesiveInALongBore) {
  // 10 mm of a 126 um bore at 4 Pa s and 0.1 mm/s: 3.1 mN.
  const Drag law = {4};
  EXPECT_CLOSE(0.1e-3 * drag(law, kAnnulus, 0, 10e-3).axial, 3.1e-3, 2e-2);
}

// The coefficients are integrals of the film's pressure around the circumference.
TEST(Drag, SqueezeFilmIsTheIntegralOfThePressure) {
  const Drag law = {0.7};
  const double e = 0.3e-6, length = 40e-6, c = kAnnulus.clearance();
  double radial = 0, tangential = 0, couette = 0;
  const int n = 20000;
  for (int i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * (i + 0.5) / n, h = c - e * std::cos(angle);
    const double share = 0.7 * 62.5e-6 * 2 * std::numbers::pi / n;
    radial += share * std::pow(length, 3) * std::pow(std::cos(angle), 2) / std::pow(h, 3);
    tangential += share * std::pow(length, 3) * std::pow(std::sin(angle), 2) / std::pow(h, 3);
    couette += share * length / h;
  }
  const DragCoefficients k = drag(law, kAnnulus, e, length);
  EXPECT_CLOSE(k.radial, radial, 1e-9);
  EXPECT_CLOSE(k.tangential, tangential, 1e-9);
  EXPECT_CLOSE(k.axial, couette, 1e-9);
}

TEST(Drag, StaysFiniteInContact) {
  const Drag law = {1};
  EXPECT_TRUE(std::isfinite(drag(law, kAnnulus, 0.6e-6, 1e-4).radial));
}

// A fibre pulled through a filled bore lags behind the hand by drag over stiffness.
TEST(Drag, HoldsBackAFibreThatMoves) {
  const Scene scene = testing::bare({"laws.drag={\"form\":\"corrected\",\"viscosity_Pa_s\":1}"});
  StepResult r;
  State& state = r.state;
  state.tip = state.command = (Pose() << -100e-6, 0, 0, 0, 0).finished();
  for (int n = 0; n < 3000; ++n) {
    Pose hand = state.command;
    hand[0] -= 5e-9;
    step_on(scene.world, hand, 1e-3, r);
  }
  const double expected = 5e-6 * drag(*scene.world.laws.drag, kAnnulus, 0, -state.tip[0]).axial;
  EXPECT_CLOSE(forces(scene.world, r).force(Term::drag).x(), expected, 1e-2);
  EXPECT_CLOSE(r.holder[0], expected, 1e-2);
}

}  // namespace
}  // namespace ferrule
