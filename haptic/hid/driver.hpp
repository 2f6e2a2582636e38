// A driver of a kind of HID device: what it is recognised by, what it needs of it, and how it is
// made. Each driver's own file describes it as one row; haptic/hid/drivers.cpp has the table.
#pragma once

#include <array>
#include <memory>

#include "haptic/device.hpp"
#include "haptic/hid/axis_reader.hpp"
#include "haptic/hid/hid.hpp"

namespace ferrule {

// A device on HID reports.
class HidDevice : public Device {
 public:
  virtual const AxisReader& axes() const noexcept = 0;
  // What was rendered last along its X and Y, of what it can do [-]; 0 without force.
  virtual std::array<double, 2> force() const noexcept { return {}; }
};

// What its ends stand for, in the hand's world.
struct DeviceRange {
  double speed, tilt_rate;  // of a velocity device at full deflection [m/s], [rad/s]
  double reach;             // of a position device to either side [m]
};

struct DriverSettings {
  DeviceRange range;
  double full_force;  // what a device with force does at most, at the hand [N]; the rest is cut
  HandPose start;     // where the hand is at the start
};

// A modelled device behind a transport: SIMULATED, nobody's hand is on it. Its time stands still
// between calls of `advance`.
class FakeTransport : public HidTransport {
 public:
  using HidTransport::HidTransport;
  // Lets time pass until `t` [s], sending the reports of that time. Time does not go back.
  virtual void advance(double t) = 0;
  // The hand on it: axes X Y Z Rx Ry Rz [counts], buttons (bit k: button k + 1).
  virtual void deflect(const std::array<int, 6>& counts) noexcept = 0;
  virtual void press(std::uint8_t buttons) = 0;
};

// How a device gives force.
struct ForceDriver {
  double report_period;  // longest time between reports of a device that moves [s]
  // Along which of x y z it has a motor: 1, or 0. Throws DeviceTrouble.
  Eigen::Vector3d (*motors)(const HidInfo& info);
  // The coarsest step of its position along an axis with a motor, where full deflection is `reach`
  // [m]. Throws DeviceTrouble.
  double (*step)(const HidInfo& info, double reach);
};

struct Driver {
  const char* name;  // in lists of devices, and of the operator in recordings
  // Is it one, by ids, usage and report descriptor, never by its name? May throw DeviceTrouble
  // where the descriptor is broken: then it is none.
  bool (*recognises)(const HidInfo& info);
  // What it is if it is never to be driven, though its maker makes some that are; null if it may.
  const char* (*never)(const HidInfo& info) noexcept;
  // Throws DeviceTrouble where it lacks something without which it cannot be driven.
  void (*check)(const HidInfo& info);
  // The driver of an open device; `transport` must outlive it. Throws DeviceTrouble.
  std::unique_ptr<HidDevice> (*make)(HidTransport& transport, const DriverSettings& settings);
  const ForceDriver* force;  // null: it has none
  const char* fake_name;     // of its model on the command line, "fake:..."
  std::unique_ptr<FakeTransport> (*fake)();
};

}  // namespace ferrule
