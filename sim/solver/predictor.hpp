// The predictor of a sub-step: a Newton step from the linearization that the last one left
// (Linearization), without an evaluation of the potential; and its corrector.
#pragma once

#include "sim/solver/newton.hpp"
#include "sim/solver/step.hpp"

namespace ferrule {

// Where the linearization of the last sub-step says that this one ends.
struct Prediction {
  bool valid = false;  // near enough; the rest, but for `tip`, is only set where it is
  PoseVector tip;      // at its end
  BlockLdl factors;    // of the Hessian where the sub-step begins
  PoseVector move = {};
  double slope = 0;         // of the energy along the move where it begins [J]
  const char* reason = "";  // why it is valid, or not
};

// From `now`, whose linearization may be missing. Moves the friction limits of `frozen` to those
// at the end; they are of no use where the prediction is not valid.
Prediction predict(const World& world, const StepResult& now, FrozenCoefficients& frozen) noexcept;

// The corrector: goes on from the prediction, evaluated there, with the `curvature` of the
// linearization. False where the prediction is too far from a minimum.
bool correct(const World& world, const FrozenCoefficients& frozen, const Prediction& end,
             const PoseVector& curvature, Iterate& iterate) noexcept;

// Determinant of the stiffness that holds the end where a sub-step left it, with friction
// and how its limits change, from its linearization [(N/m)^3 (N m/rad)^2]; NaN without one. Up to a
// fold, where the pose is lost, it falls to 0 as the root of what is left of the path.
double stiffness_determinant(const World& world, const StepResult& now) noexcept;

// At which part of the move to its prediction, with the potential evaluated there, an open contact
// begins, as its depth goes to first order; NaN where none does.
double contact_onset(const World& world, const State& before, const Prediction& end,
                     const Potential& potential) noexcept;

}  // namespace ferrule
