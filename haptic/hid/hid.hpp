// The way to a HID device: reports in, reports out. Behind it is hidapi with a real device, or the
// firmware model of haptic/hid/fake_firmware.hpp.
//
// Reports begin with their id; where a device numbers none, what is written begins with 0 and what
// is read does not (haptic/hid/axis_reader.hpp knows). Nothing here throws once a device is open:
// the loop asks often, and a device that is gone is a value.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "haptic/trouble.hpp"

namespace ferrule {

struct HidInfo {
  std::string path;  // "/dev/hidraw0"
  std::uint16_t vendor = 0, product = 0;
  std::uint16_t usage_page = 0, usage = 0;  // of its first application collection; 0: not known
  std::string name;                         // what it calls itself; may be empty
  std::vector<std::uint8_t> descriptor;     // report descriptor; empty: cannot be read
};

class HidTransport {
 public:
  explicit HidTransport(HidInfo info) : info_(std::move(info)) {}
  HidTransport(const HidTransport&) = delete;
  HidTransport& operator=(const HidTransport&) = delete;
  virtual ~HidTransport() = default;

  const HidInfo& info() const noexcept { return info_; }

  // The next input report, waiting for it at most `timeout` [ms]: its length, 0 if none came, -1 if
  // the device is gone.
  virtual int read(std::span<std::uint8_t> report, int timeout) noexcept = 0;
  // Output report. False: it did not arrive; the device is gone or refused it.
  virtual bool write(std::span<const std::uint8_t> report) noexcept = 0;
  virtual bool send_feature(std::span<const std::uint8_t> report) noexcept = 0;
  // Feature report of the id in report[0]: its length with the id, or -1.
  virtual int get_feature(std::span<std::uint8_t> report) noexcept = 0;

 private:
  HidInfo info_;
};

// Every HID device of the machine, by path; none if it has no hidraw. Needs no permission.
std::vector<HidInfo> list_hid();

// Throws DeviceTrouble if it cannot be opened.
std::unique_ptr<HidTransport> open_hid(const HidInfo& info);

}  // namespace ferrule
