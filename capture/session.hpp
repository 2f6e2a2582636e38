// The loop between hand and fibre: read the device, step the simulator, let the hand feel it,
// record.
#pragma once

#include <functional>

#include "capture/recorder.hpp"
#include "haptic/device.hpp"

namespace ferrule {

// Runs one episode from `start`, the hand feeling what `sensor` reads, until the device is
// finished, the insertion fails, or `stop` returns true, for the scene's longest trial at most;
// every tick becomes a row. The outcome is `inserted` if the fibre got deep enough, `stopped_short`
// if the operator finished before that, and `interrupted` if `stop` ended it or the device was
// lost.
Outcome run_episode(const Scene& scene, const State& start, Device& device, ForceSensor sensor,
                    double period, const std::function<void(const RowVector&)>& record,
                    const std::function<bool()>& stop);

// The same with the device's counts of each row.
Outcome run_episode(const Scene& scene, const State& start, Device& device, ForceSensor sensor,
                    double period,
                    const std::function<void(const RowVector&, const RawCounts&)>& record,
                    const std::function<bool()>& stop);

}  // namespace ferrule
