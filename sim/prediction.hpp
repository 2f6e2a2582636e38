// The predictor of a step: Newton's method from the linearization that the last step left
// (Linearization), without an evaluation of the potential; and its corrector.
#pragma once

#include "sim/minimum.hpp"

namespace ferrule {

// Where the linearization of the last step says that this one ends: a Newton step from there,
// without an evaluation of the potential.
struct Prediction {
  bool valid = false;  // near enough; the rest, but for `tip`, is only set where it is
  PoseVector tip;      // at its end
  Eliminated hessian;  // where the step begins
  PoseVector move = {};
  double slope = 0;  // of the energy along the move where it begins [J]
};

// From `state`, whose linearization may be missing. Moves the friction limits of `frozen` to those
// at the end; they are of no use where the prediction is not valid.
Prediction predict(const World& world, const State& state, FrozenCoefficients& frozen) noexcept;

// The corrector: goes on from the prediction, evaluated there (found.there), with the `curvature` of
// the linearization. False where the prediction is too far from a minimum.
bool correct(const World& world, const FrozenCoefficients& frozen, const Prediction& end,
             const PoseVector& curvature, Minimum& found) noexcept;

// Determinant of the stiffness that holds the end in a state that a step left, with friction and
// how its limits give way, from its linearization [(N/m)^3 (N m/rad)^2]; NaN without one. Up to a
// fold, where the pose is lost, it falls to 0 as the root of the way that is left.
double stiffness_determinant(const World& world, const State& state) noexcept;

// Where on the way to its prediction, evaluated there, an open contact begins, as its depth goes to
// first order; NaN where none does.
double first_touch(const World& world, const State& before, const Prediction& end,
                   const Potential& there) noexcept;

}  // namespace ferrule
