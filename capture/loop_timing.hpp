// How well this machine keeps the period of a device with the simulator in its loop.
#pragma once

#include "capture/haptic_loop.hpp"

namespace ferrule {

// Steps `scene` from `start` in a loop in time, under SCHED_FIFO as far as that is permitted, for
// `seconds` > 0 or until `stop`; the hand moves by a clearance to and fro. `period` [s], >= 1e-6.
LoopTiming time_loop(const Scene& scene, const State& start, double period, double seconds,
                     bool (*stop)() noexcept);

}  // namespace ferrule
