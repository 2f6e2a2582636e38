// The loop between hand and fibre: read the device, step the simulator, let the hand feel it, and
// record the row.
#pragma once

#include <functional>

#include "capture/recorder.hpp"
#include "haptic/device.hpp"
#include "haptic/force_feedback.hpp"
#include "insertion/watch.hpp"

namespace ferrule {

struct EpisodeEnd {
  Outcome outcome;
  InsertionSummary summary;  // up to the last row
  std::string why;           // the operator gave up, or what ended the episode; may be empty
  bool lost = false;         // the device is gone
};

// Runs one episode from `start`, the hand feeling what `sensor` reads, until the device is
// finished, the insertion fails, or `stop` returns true, for the scene's longest trial at most;
// every tick becomes a row. The outcome is `inserted` if the fibre got deep enough, `stopped_short`
// if the operator finished before that (`gave_up` if that was giving up), and `interrupted` if
// `stop` ended it or the device was lost.
//
// With `feedback` the device's hand holds the fibre, and feels it, by way of that: the rows have
// the pose of the fibre's holder. What `feedback` cannot trust ends the episode as `interrupted`,
// with no force and with the rows before it.
EpisodeEnd run_episode(const Scene& scene, const State& start, Device& device, ForceSensor sensor,
                       double period, const std::function<void(const RowVector&)>& record,
                       const std::function<bool()>& stop, ForceFeedback* feedback = nullptr);

// The same with the device's counts of each row.
EpisodeEnd run_episode(const Scene& scene, const State& start, Device& device, ForceSensor sensor,
                       double period,
                       const std::function<void(const RowVector&, const RawCounts&)>& record,
                       const std::function<bool()>& stop, ForceFeedback* feedback = nullptr);

// The force feedback of a device with this scene: the weight of the fibre at `start` is not felt.
// `coupling`: empty where the hand holds the fibre itself. `motors`: as in ForceFeedback.
ForceFeedback force_feedback(const Scene& scene, const State& start, const DeviceProfile& device,
                             const std::optional<Coupling>& coupling, double report_period,
                             const Eigen::Vector3d& motors = Eigen::Vector3d::Ones());

}  // namespace ferrule
