// The reports of a force-feedback device of the USB class "Physical Interface Devices", built from
// its report descriptor: whatever the ids, widths and order are, each field is found by its usage
// and scaled by its logical range.
//
// Fields that a report has beyond those named here are 0, or the end of their range that is nearest
// to 0. Source: USB Device Class Definition for Physical Interface Devices 1.0.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "haptic/hid/report_descriptor.hpp"

namespace ferrule {

// A report with its id, short enough for one packet.
struct HidReport {
  std::array<std::uint8_t, 65> bytes{};
  std::size_t size = 0;

  std::span<const std::uint8_t> span() const noexcept { return std::span(bytes).first(size); }
  std::span<std::uint8_t> span() noexcept { return std::span(bytes).first(size); }
};

enum class PidControl { enable, disable, stop_all, reset };
enum class PidOperation { start, stop };

struct PidBlockLoad {
  enum class Status { success, full, error };
  Status status;
  int block;  // effect block index, > 0 where it is a success
};

class PidReports {
 public:
  // Has the device a constant force, without which nothing here can be felt?
  static bool in(const HidDescriptor& descriptor) noexcept;

  // Throws DeviceTrouble naming the first thing that is missing or cannot be served (a report
  // longer than 64 bytes).
  explicit PidReports(const HidDescriptor& descriptor);

  // Feature report: make a constant effect.
  HidReport create_constant() const noexcept;
  // Feature report to ask for, and its answer.
  HidReport block_load_request() const noexcept;
  PidBlockLoad block_load(std::span<const std::uint8_t> report) const noexcept;

  // Output reports. Effect `block` is a constant force along `axis` (0: X, 1: Y) that ends after
  // `duration` [s], cut to the field's range. Directions are polar, clockwise from -Y: X is 90
  // degrees, Y is 180. Where the device has no directions the axis itself is enabled.
  HidReport set_effect(int block, int axis, double duration) const noexcept;
  // `duration` as the field of set_effect says it [s].
  double said_duration(double duration) const noexcept;
  // `force` from -1 to 1 of what the device can do, cut there; NaN is 0.
  HidReport set_constant_force(int block, double force) const noexcept;
  HidReport operation(int block, PidOperation operation) const noexcept;
  HidReport control(PidControl control) const noexcept;
  // Empty where the device has no such report.
  std::optional<HidReport> block_free(int block) const noexcept;
  std::optional<HidReport> full_device_gain() const noexcept;

  int axes() const noexcept { return axes_; }  // that take a force: 1 (X) or 2 (X, Y)

 private:
  // Payload of zeros, or of what is nearest to 0 in each field's range.
  HidReport blank(HidReportType type, std::uint8_t id) const noexcept;
  // Sets `usage` in the report: element of an array, or bit of a mask.
  void choose(HidReport& report, HidReportType type, std::uint32_t collection,
              std::uint32_t usage) const noexcept;
  void put(HidReport& report, HidReportType type, std::uint32_t collection, std::uint32_t usage,
           double value) const noexcept;

  HidDescriptor descriptor_;
  int axes_ = 1;
  std::uint8_t create_ = 0, load_ = 0, set_effect_ = 0, constant_ = 0, operation_ = 0;
  std::uint8_t control_ = 0;  // ids
};

}  // namespace ferrule
