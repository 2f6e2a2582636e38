// Which of the machine's HID devices this program can use, and what to do about those it may not.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "haptic/hid/hid.hpp"

namespace ferrule {

enum class DeviceKind { space_mouse, force_stick };
const char* name(DeviceKind kind) noexcept;

// What a device is, by its ids, usage and report descriptor, never by its name: a force stick has a
// constant force (haptic/hid/pid_reports.hpp); a SpaceMouse is in the table, or shows itself as a
// multi-axis controller (page 1, usage 8), and is not among those that are never one. Empty:
// something else.
std::optional<DeviceKind> device_kind(const HidInfo& info);

// What such a device lacks, so that its driver cannot use it; empty: nothing.
std::string missing(const HidInfo& info, DeviceKind kind);

struct FoundDevice {
  HidInfo info;
  std::optional<DeviceKind> kind;  // empty: never used, though its maker makes some that are
  bool permitted = false;          // may this user open it?
  std::string missing{};           // as above

  bool usable() const noexcept { return kind && missing.empty() && permitted; }
  bool forbidden() const noexcept { return kind && missing.empty() && !permitted; }
};

// Usable, unusable, forbidden and never used ones, by path; other devices are left out.
std::vector<FoundDevice> find_devices();

// The udev rule that lets whoever sits at the machine open the device, and the commands that put it
// in force.
std::string udev_rule(const HidInfo& info);
std::string udev_command(const HidInfo& info);

// The device of that path, or the first usable one for "auto". Throws DeviceTrouble.
FoundDevice choose_device(const std::string& path);

}  // namespace ferrule
