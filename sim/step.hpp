// One step in time: the implicit quasi-static step.
//
// The fibre has no inertia to speak of at these time scales; at every instant it rests where the
// potential of sim/potential.hpp is stationary. A step minimises that potential from where the
// fibre was (sim/minimum.hpp): the energy never rises, so no step size blows up, and the fibre
// follows the branch it is on until that branch ends (snap-in, pull-off, slip).
//
// A predictor, the linearization of the forces where the last step ended, says where it ends, and
// one evaluation there corrects it: a smooth step takes one evaluation of the potential. Where
// something happens on the way, or the minimum is not found soon, the step is halved. In free air
// and in the lead-in, while nothing touches, the end hangs on its holder and nothing is evaluated;
// nor is it in smooth stretches, as long as their tangent is good enough (sim/tangent.hpp).
#pragma once

#include "sim/breakdown.hpp"
#include "sim/world.hpp"

namespace ferrule {

enum class StepStatus {
  ok,
  not_converged,  // finite and no higher in energy than before, but not stationary
  bad_command,    // the command or dt is not finite, or dt < 0: the state is unchanged
  capped,  // not stationary yet: kMostEvaluations were spent, the next step goes on from there
};

// The most evaluations of the potential that a step takes, for each of the world's longest steps
// that it is divided into.
inline constexpr int kMostEvaluations = 56;

struct StepResult {
  StepResult() = default;
  explicit StepResult(const State& start) noexcept : state(start) {}

  State state;
  // Along a tangent only the holder's is that of now, and the terms those of the step solved last
  // (all_forces()).
  Breakdown forces;
  StepStatus status = StepStatus::ok;
  int evaluations = 0;  // of the potential
  int iterations = 0;   // Newton iterations, all sub-steps together
  int substeps = 0;
  int halvings = 0;  // of sub-steps: the minimum was not found soon, or an event was located
};

// The forces of all terms where a step has ended.
Breakdown all_forces(const World& world, const StepResult& now) noexcept;

// From `state` over `dt` [s] to `command` [m, rad]. Never throws, never allocates, never
// returns a value that is not finite (if `state` is finite).
StepResult step(const World& world, const State& state, const Pose& command, double dt) noexcept;
// The same from now.state, in place, bit for bit, but for the forces of terms along a tangent.
// `now` is what a step made, or StepResult(state).
void step_on(const World& world, const Pose& command, double dt, StepResult& now) noexcept;

}  // namespace ferrule
