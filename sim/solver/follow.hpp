// The fibre along given commands, with nobody at the hand.
#pragma once

#include <utility>

#include "sim/solver/step.hpp"

namespace ferrule {

// Steps from `start` to commands(0) at once (over no time: the forces there), then to commands(1),
// ..., commands(count - 1), each over `period` [s]. `each(n, result)` is shown every result; false
// ends it.
template <class Commands, class Each>
void follow(const World& world, const State& start, std::ptrdiff_t count, double period,
            const Commands& commands, const Each& each) {
  StepResult result(start);
  for (std::ptrdiff_t n = 0; n < count; ++n) {
    step_on(world, commands(n), n == 0 ? 0.0 : period, result);
    if (!each(n, std::as_const(result))) return;
  }
}

}  // namespace ferrule
