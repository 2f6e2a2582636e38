// Force on the hand through a force-feedback device (haptic/hid/pid_reports.hpp), one constant
// effect per axis.
//
// Dead man's switch: each effect ends by itself after kDuration, and is started again every kAgain.
// If this program dies (kill -9, a crash, a pulled cable) nobody starts it again, and the device is
// without force kDuration later, whatever was sent last.
#pragma once

#include "haptic/hid/hid.hpp"
#include "haptic/hid/pid_reports.hpp"

namespace ferrule {

class ForceOutput {
 public:
  static constexpr double kDuration = 0.15;  // of an effect [s]
  static constexpr double kAgain = 0.03;     // between its starts [s]

  // Resets the device, makes the effects with zero force, and enables the actuators. `transport`
  // must outlive this. Throws DeviceTrouble if the device has no force feedback, no effects of 100
  // to 200 ms, refuses a report, or has no room for the effects; then it has been left as `stop`
  // leaves it.
  explicit ForceOutput(HidTransport& transport);
  ForceOutput(const ForceOutput&) = delete;
  ForceOutput& operator=(const ForceOutput&) = delete;
  // Stops.
  ~ForceOutput();

  // Forces along X and Y at time t [s], from -1 to 1 of what the device can do; what is beyond is
  // cut, NaN is 0. Writes one report at most, so that it takes no longer than a packet: a start
  // that is due, or the force that has waited longest. No force at all waits for nothing: it goes
  // out at once, one report for each axis. False: the device is gone.
  bool update(double t, const std::array<double, 2>& force) noexcept;

  // Zero force, all effects stopped, actuators disabled, effects freed, device reset; as far as the
  // device still listens. Nothing is written after it.
  void stop() noexcept;

  int axes() const noexcept { return reports_.axes(); }

 private:
  struct Effect {
    int block = 0;
    double started = 0;  // [s]
    HidReport sent;      // Set Constant Force as the device has it
  };

  void start();
  void write(const HidReport& report, const char* what);
  bool try_write(const HidReport& report) noexcept;

  HidTransport& transport_;
  PidReports reports_;
  std::array<Effect, 2> effects_;
  int made_ = 0;  // effects that the device has
  int next_ = 0;  // axis whose force is looked at first
  bool running_ = false;
};

}  // namespace ferrule
