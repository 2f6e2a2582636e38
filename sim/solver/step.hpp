// One step in time: the implicit quasi-static step (sim/solver/README.md).
//
// The fibre has no inertia to speak of at these time scales; at every instant it rests where the
// potential of sim/terms/potential.hpp is stationary. A step minimises that potential from where
// the fibre was: the energy never rises, so no step size blows up, and the fibre follows the branch
// it is on until that branch ends (snap-in, pull-off, slip).
#pragma once

#include "sim/model/breakdown.hpp"
#include "sim/model/world.hpp"
#include "sim/solver/trace.hpp"
#include "sim/solver/warm_start.hpp"

namespace ferrule {

enum class StepStatus {
  ok,
  not_converged,    // finite and no higher in energy than before, but not stationary
  bad_command,      // the command or dt is not finite, or dt < 0: the state is unchanged
  iteration_limit,  // not stationary yet: SolverParameters::max_evaluations were spent, the next
                    // step goes on from there
};

struct StepResult {
  StepResult() = default;
  explicit StepResult(const State& start) noexcept : state(start) {}

  // Was the step taken without an evaluation, along the tangent of one before?
  bool extrapolated() const noexcept { return evaluations == 0 && warm_start.extrapolation; }

  State state;
  Wrench holder = Wrench::Zero();  // of the fibre on its holder [N, N m]
  StepStatus status = StepStatus::ok;
  int evaluations = 0;  // of the potential
  int iterations = 0;   // Newton iterations, all sub-steps together
  int substeps = 0;     // accepted
  int rejected = 0;     // sub-steps: not converged soon, or something happened in them
  WarmStart warm_start;
};

// From now.state over `dt` [s] to `command` [m, rad], in place, with the warm start of the step
// before. `now` is what a step made, or StepResult(state). Never throws and never allocates, but
// for a `trace`, which it appends to; never makes a value that is not finite (if now.state is
// finite).
void step_on(const World& world, const Pose& command, double dt, StepResult& now,
             StepTrace* trace = nullptr) noexcept;
// The same from a state alone.
StepResult step(const World& world, const State& state, const Pose& command, double dt,
                StepTrace* trace = nullptr) noexcept;

// The force of each term where a step has ended. Where the step was extrapolated that takes an
// evaluation.
Breakdown forces(const World& world, const StepResult& now) noexcept;

}  // namespace ferrule
