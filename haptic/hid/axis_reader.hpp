// The axes and buttons of a HID device, followed through its input reports.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "haptic/device.hpp"
#include "haptic/hid/hid.hpp"
#include "haptic/hid/report_descriptor.hpp"

namespace ferrule {

// Where an axis is: in which report, and which numbers it may be.
struct AxisPlace {
  bool there = false;
  HidField field;
  double centre = 0, limit = 0;  // middle and half of the declared range [counts]
};

class AxisReader {
 public:
  // Axes X Y Z Rx Ry Rz (usages 30 to 35 of page 1) and buttons (page 9, the first 32) as the
  // descriptor has them, within its multi-axis controller where it has one; the first field of a
  // usage counts. An axis beyond 32 bits with a sign is left out.
  explicit AxisReader(const HidDescriptor& descriptor);
  // Six 16-bit axes of +-350 in report 1 (`combined`), or three each in reports 1 and 2; buttons in
  // report 3.
  static AxisReader space_mouse(bool combined);

  // Takes one input report as it came. Reports that carry no axis and no button, and those that are
  // too short, change nothing. Returns the id of the report (0 where there are none) if it carried
  // an axis or button, and -1 if not.
  int take(std::span<const std::uint8_t> report) noexcept;
  // Takes every report that waits, at time t [s]. False: the device is gone.
  bool poll(HidTransport& transport, double t) noexcept;
  // When a report with an axis or button came last [s]; -1 if none has.
  double heard(int report) const noexcept { return heard_[static_cast<std::size_t>(report)]; }
  // Sets the axes of one report to their centre; false if they all were there.
  bool centre(int report) noexcept;

  int axes() const noexcept;                                  // how many there are
  std::int64_t reports() const noexcept { return reports_; }  // that carried an axis or button
  // Of these, the ones that were the report before again, byte for byte.
  std::int64_t repeats() const noexcept { return repeats_; }
  const std::array<AxisPlace, kRawAxes>& places() const noexcept { return places_; }
  const RawCounts& counts() const noexcept { return counts_; }
  std::uint32_t buttons() const noexcept { return buttons_; }  // bit k: button k + 1

 private:
  AxisReader() = default;
  void settle() noexcept;

  bool numbered_ = true;
  std::array<AxisPlace, kRawAxes> places_;
  std::vector<HidField> button_fields_;
  RawCounts counts_ = RawCounts::Zero();
  std::uint32_t buttons_ = 0;
  std::int64_t reports_ = 0, repeats_ = 0;
  std::array<std::uint8_t, 64> last_{};  // report that carried an axis or button; cut
  std::size_t last_size_ = 0;
  std::array<double, 256> heard_;
};

}  // namespace ferrule
