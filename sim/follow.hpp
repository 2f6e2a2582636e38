// The fibre along given commands, with nobody at the hand.
#pragma once

#include "sim/step.hpp"

namespace ferrule {

// Steps from `start` to commands(0) at once (over no time: the forces there), then to commands(1),
// ..., commands(count - 1), each over `period` [s]. `each(n, result)` is shown every result; false
// ends it.
template <class Commands, class Each>
void follow(const World& world, const State& start, std::ptrdiff_t count, double period,
            const Commands& commands, const Each& each) {
  State state = start;
  for (std::ptrdiff_t n = 0; n < count; ++n) {
    const StepResult result = step(world, state, commands(n), n == 0 ? 0.0 : period);
    state = result.state;
    if (!each(n, result)) return;
  }
}

}  // namespace ferrule
