// Free flight: in air, and in the lead-in while nothing touches there, the end hangs on its holder
// alone, without inertia:
//   tip = command + sag.
// Nothing is evaluated, and a step is as long as it is.
#pragma once

#include "sim/solver/step.hpp"

namespace ferrule {

// A step from now.state over `dt` [s] to `command` [m, rad], in place; `now` as in step_on. False,
// with `now` as it was, where something may act on the end on the way.
bool fly_free(const World& world, const Pose& command, double dt, StepResult& now) noexcept;

}  // namespace ferrule
