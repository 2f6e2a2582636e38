// Recording one episode into a folder: used by `record` and `demo`.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "app/keys.hpp"
#include "capture/haptic_loop.hpp"
#include "capture/recorder.hpp"
#include "haptic/hid/device_list.hpp"
#include "sim/base/control_period.hpp"

namespace ferrule {

struct Recorded {
  std::string file;  // empty: the operator discarded it, it has no row, or it is not whole yet
  InsertionEnd end;
  double period = kControlPeriod;      // of the loop [s]
  std::optional<LoopTiming> timing{};  // of a device
  int rating = 0;
  bool discarded = false;
  bool last = false;                    // the operator ended the recording with it
  std::unique_ptr<Recorder> writing{};  // of a file that is not whole yet

  // Waits until it is. Throws FileTrouble.
  void wait();
};

// Which episode it is, and where it goes.
struct EpisodePlace {
  std::string operator_;
  EpisodeClaim claim;  // is handed on to the recorder
  // Of a person: who, when the sitting began, and whether the hand goes on after the goal.
  struct Sitting {
    std::string trainee, began;
    bool goes_on;
  };
  std::optional<Sitting> sitting{};
  // Of an operator who has phases: the one that the row just recorded is of (EpisodeInfo::phases).
  std::function<std::string()> phase{};
};

// Of so many episodes the files are written while the next one is recorded.
inline constexpr std::size_t kWriting = 2;

// With a simulated hand or a controller, as fast as it goes; the file is written while the caller
// goes on. Throws FileTrouble.
Recorded record_one(const TrialSetup& trial, Device& device, EpisodePlace place);

// The operator of a recording with a device.
std::string operator_name(const OpenDevice& device);

struct HandSettings {
  double gain = 1;                   // insertion/hand_device.hpp
  DeviceProfile profile;             // of a device with force
  std::optional<Coupling> coupling;  // of a device with force
};

// The hand of a person on the device, or a simulated one on a model of it. Throws DeviceTrouble.
std::unique_ptr<Device> hand_on(const OpenDevice& device, const HandSettings& settings,
                                const Scene& scene, const State& start);

// With a person's hand, in time. At a terminal keys start, end, discard and rate the episode.
// Empty: the operator ended the recording instead of beginning. Throws DeviceTrouble, FileTrouble.
std::optional<Recorded> record_by_hand(const OpenDevice& device, const HandSettings& settings,
                                       const TrialSetup& trial, EpisodePlace place, Keys& keys);

}  // namespace ferrule
