#include "capture/loop_timing.hpp"

#include <cmath>

#include "haptic/real_time.hpp"
#include "sim/base/elementary.hpp"

namespace ferrule {

LoopTiming time_loop(const Scene& scene, const State& start, double period, double seconds,
                     bool (*stop)() noexcept) {
  const RealTime real_time;
  State state = start;
  PeriodClock clock(period);
  const auto periods = static_cast<std::int64_t>(std::ceil(seconds / period));
  for (std::int64_t n = 0; n < periods && !stop(); ++n) {
    clock.wait();
    Pose hand = start.command;
    hand[1] +=
        scene.world.annulus.clearance() * elementary::sin(10 * static_cast<double>(n) * period);
    state = step(scene.world, state, hand, period).state;
  }
  return {clock.statistics(), real_time.scheduling_error(), real_time.locking_error()};
}

}  // namespace ferrule
