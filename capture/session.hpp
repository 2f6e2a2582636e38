// The loop between hand and fibre: read the device, step the simulator, let the hand feel it,
// record.
#pragma once

#include <functional>

#include "capture/recorder.hpp"
#include "haptic/device.hpp"
#include "sim/insertion.hpp"

namespace ferrule {

struct EpisodeEnd {
  Outcome outcome;
  InsertionSummary summary;  // up to the last row
  std::string why;           // the operator gave up, where that is the outcome
};

// Runs one episode from `start`, the hand feeling what `sensor` reads, until the device is
// finished, the insertion fails, or `stop` returns true, for the scene's longest trial at most;
// every tick becomes a row. The outcome is `inserted` if the fibre got deep enough, `stopped_short`
// if the operator finished before that (`gave_up` if that was giving up), and `interrupted` if
// `stop` ended it or the device was lost.
EpisodeEnd run_episode(const Scene& scene, const State& start, Device& device, ForceSensor sensor,
                       double period, const std::function<void(const RowVector&)>& record,
                       const std::function<bool()>& stop);

// The same with the device's counts of each row.
EpisodeEnd run_episode(const Scene& scene, const State& start, Device& device, ForceSensor sensor,
                       double period,
                       const std::function<void(const RowVector&, const RawCounts&)>& record,
                       const std::function<bool()>& stop);

}  // namespace ferrule
