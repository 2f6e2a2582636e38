// The fibre along given hand poses, with nobody at the hand.
#pragma once

#include "sim/step.hpp"

namespace ferrule {

// Steps from `start` to hand(0) at once (over no time: the forces there), then to hand(1), ...,
// hand(count - 1), each over `period` [s]. `each(n, result)` is shown every result; false ends it.
template <class Hand, class Each>
void follow(const World& world, const State& start, std::ptrdiff_t count, double period,
            const Hand& hand, const Each& each) {
  State state = start;
  for (std::ptrdiff_t n = 0; n < count; ++n) {
    const StepResult result = step(world, state, hand(n), n == 0 ? 0.0 : period);
    state = result.state;
    if (!each(n, result)) return;
  }
}

}  // namespace ferrule
