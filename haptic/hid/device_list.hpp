// Which of the machine's HID devices this program can use, and what to do about those it may not.
#pragma once

#include <string>
#include <vector>

#include "haptic/hid/drivers.hpp"

namespace ferrule {

struct FoundDevice {
  HidInfo info;
  const Driver* driver = nullptr;  // null: never driven, though its maker makes some that are
  bool permitted = false;          // may this user open it?
  std::string missing{};           // what it lacks, so that its driver cannot use it
  const char* never = nullptr;     // what it is, where it is never driven

  bool usable() const noexcept { return driver && missing.empty() && permitted; }
  bool forbidden() const noexcept { return driver && missing.empty() && !permitted; }
};

// Usable, unusable, forbidden and never used ones, by path; other devices are left out.
std::vector<FoundDevice> find_devices();

// The udev rule that lets whoever sits at the machine open the device, and the commands that put it
// in force.
std::string udev_rule(const HidInfo& info);
std::string udev_command(const HidInfo& info);

// The device of that path, or the first usable one for "auto". Throws DeviceTrouble.
FoundDevice choose_device(const std::string& path);

// A device that can be read from, or the model of one.
struct OpenDevice {
  const Driver* driver;
  std::unique_ptr<HidTransport> transport;
  FakeTransport* fake;  // the transport, if it is a model; else null
};
// `wanted`, the value of the command line's `option`: "auto", a path, or a model's name. Throws
// DeviceTrouble, and BadInput where there is no such model.
OpenDevice open_device(const std::string& option, const std::string& wanted);

}  // namespace ferrule
