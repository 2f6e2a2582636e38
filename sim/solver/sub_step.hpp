// One sub-step: predictor, corrector, Newton's method, and friction coupled to the contacts.
#pragma once

#include "sim/solver/newton.hpp"
#include "sim/solver/step.hpp"

namespace ferrule {

// From `now` over dt [s] to `command`, in at most `max_evaluations`; `frozen` is freeze() of
// that, and frozen again where the end slides off an edge. Given `event` the sub-step may be
// divided: it ends, not converged, as soon as something happens or
// SolverParameters::divisible_evaluations are spent, and *event is about which part of the sub-step
// that was at (unchanged where not known). Without, an iterate that is no better than staying is
// replaced by that.
Iterate solve_sub_step(const World& world, const StepResult& now, const Pose& command, double dt,
                       int max_evaluations, double* event, FrozenCoefficients& frozen,
                       StepTrace* trace) noexcept;

}  // namespace ferrule
