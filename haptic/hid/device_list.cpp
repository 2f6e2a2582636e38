#include "haptic/hid/device_list.hpp"

#include <unistd.h>

#include <cstdio>

#include "sim/base/error.hpp"

namespace ferrule {

std::vector<FoundDevice> find_devices() {
  std::vector<FoundDevice> found;
  for (HidInfo& info : list_hid()) {
    const Driver* const driver = driver_of(info);
    const char* const never = never_driven(info);
    if (!driver && !never) continue;
    const bool permitted = ::access(info.path.c_str(), R_OK | W_OK) == 0;
    std::string lacks = driver ? missing(info, *driver) : "";
    found.push_back({std::move(info), driver, permitted, std::move(lacks), never});
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
  throw DeviceTrouble(std::string("no device is connected; --device ") +
                      drivers().front().fake_name + " tries without one");
}

OpenDevice open_device(const std::string& option, const std::string& wanted) {
  if (const Driver* const driver = fake_driver(wanted)) {
    std::unique_ptr<FakeTransport> fake = driver->fake();
    FakeTransport* const model = fake.get();
    return {driver, std::move(fake), model};
  }
  if (wanted.starts_with("fake:"))
    throw BadInput(option + " " + wanted + ": must be " + fake_names(" or "));
  const FoundDevice found = choose_device(wanted);
  return {found.driver, open_hid(found.info), nullptr};
}

}  // namespace ferrule
