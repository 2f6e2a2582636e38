#include "haptic/hid/device_list.hpp"

#include <unistd.h>

#include <cstdio>

#include "haptic/hid/force_stick.hpp"
#include "haptic/hid/space_mouse.hpp"

namespace ferrule {

const char* name(DeviceKind kind) noexcept {
  return kind == DeviceKind::space_mouse ? "SpaceMouse" : "force stick";
}

std::optional<DeviceKind> device_kind(const HidInfo& info) {
  if (never_a_space_mouse(info.vendor, info.product)) return std::nullopt;
  const bool multi_axis = info.usage_page == 1 && info.usage == 8;
  const bool unknown = info.usage_page == 0;
  if (multi_axis || (unknown && space_mouse_layout(info.vendor, info.product)))
    return DeviceKind::space_mouse;
  try {
    const HidDescriptor descriptor = parse_report_descriptor(info.descriptor);
    if (describes(descriptor, kMultiAxis)) return DeviceKind::space_mouse;
    if (PidReports::in(descriptor)) return DeviceKind::force_stick;
  } catch (const DeviceTrouble&) {
    // Not one that this program could drive.
  }
  return std::nullopt;
}

std::string missing(const HidInfo& info, DeviceKind kind) {
  try {
    if (kind == DeviceKind::space_mouse) {
      space_mouse_axes(info);
    } else {
      force_stick_axes(info);
      force_stick_motors(info);
    }
  } catch (const DeviceTrouble& trouble) {
    const std::string why = trouble.what(), path = info.path + ": ";
    return why.starts_with(path) ? why.substr(path.size()) : why;
  }
  return {};
}

std::vector<FoundDevice> find_devices() {
  std::vector<FoundDevice> found;
  for (HidInfo& info : list_hid()) {
    const auto kind = device_kind(info);
    if (!kind && !never_a_space_mouse(info.vendor, info.product)) continue;
    const bool permitted = ::access(info.path.c_str(), R_OK | W_OK) == 0;
    std::string lacks = kind ? missing(info, *kind) : "";
    found.push_back({std::move(info), kind, permitted, std::move(lacks)});
  }
  return found;
}

// The kernel names a HID device BUS:VENDOR:PRODUCT.NUMBER, on USB and Bluetooth alike.
std::string udev_rule(const HidInfo& info) {
  char rule[96];
  std::snprintf(rule, sizeof rule,
                "KERNEL==\"hidraw*\", KERNELS==\"*:%04X:%04X.*\", TAG+=\"uaccess\"", info.vendor,
                info.product);
  return rule;
}

std::string udev_command(const HidInfo& info) {
  return "echo '" + udev_rule(info) +
         "' | sudo tee -a /etc/udev/rules.d/70-ferrule.rules && sudo udevadm control --reload && "
         "sudo udevadm trigger --subsystem-match=hidraw";
}

FoundDevice choose_device(const std::string& path) {
  bool forbidden = false;
  std::string unusable;
  for (FoundDevice& device : find_devices()) {
    if (path != "auto" && device.info.path != path) continue;
    if (device.usable()) return std::move(device);
    forbidden = forbidden || device.forbidden();
    if (!device.missing.empty()) unusable = device.info.path + ": " + device.missing;
  }
  if (forbidden)
    throw DeviceTrouble((path == "auto" ? "a device was found" : path + ": found") +
                        std::string(", but not permitted: \"ferrule devices\" says the udev rule"));
  if (!unusable.empty()) throw DeviceTrouble(unusable);
  if (path != "auto")
    throw DeviceTrouble(path + ": no device that can be used (\"ferrule devices\" lists them)");
  throw DeviceTrouble("no device is connected; --device fake:spacemouse tries without one");
}

}  // namespace ferrule
