#include "haptic/hid/axis_reader.hpp"

#include <algorithm>
#include <limits>

namespace ferrule {
namespace {

constexpr std::uint32_t kDesktop = 0x1u << 16, kButtons = 0x9u << 16;
constexpr std::uint32_t kUsageX = 0x30;
constexpr std::size_t kMostButtons = 32;
constexpr int kMostReports = 256;      // reports per poll: more than any kernel keeps
constexpr int kSpaceMouseLimit = 350;  // declared by all of them [counts]

}  // namespace

AxisReader::AxisReader(const HidDescriptor& descriptor) : numbered_(descriptor.numbered) {
  const std::uint32_t within = describes(descriptor, kMultiAxis) ? kMultiAxis : 0;
  for (std::size_t axis = 0; axis < kRawAxes; ++axis) {
    const auto usage = kDesktop | (kUsageX + static_cast<std::uint32_t>(axis));
    const HidField* field = find_field(descriptor, HidReportType::input, usage, within);
    if (!field || !field->variable || field->logical_max <= field->logical_min) continue;
    if (field->logical_max > std::numeric_limits<std::int32_t>::max()) continue;
    places_[axis].there = true;
    places_[axis].field = *field;
  }
  for (const HidField& field : descriptor.fields)
    if (field.type == HidReportType::input && field.variable && !field.usages.empty() &&
        (field.usages[0] & 0xFFFF0000u) == kButtons && button_fields_.size() < kMostButtons)
      button_fields_.push_back(field);
  settle();
}

AxisReader AxisReader::space_mouse(bool combined) {
  AxisReader reader;
  for (std::size_t axis = 0; axis < kRawAxes; ++axis) {
    const std::size_t report = combined || axis < 3 ? 1 : 2;
    HidField& field = reader.places_[axis].field;
    field.report = static_cast<std::uint8_t>(report);
    field.bit = static_cast<std::uint16_t>(16 * (combined ? axis : axis % 3));
    field.size = 16;
    field.logical_min = -kSpaceMouseLimit;
    field.logical_max = kSpaceMouseLimit;
    reader.places_[axis].there = true;
  }
  HidField button;
  button.report = 3;
  button.size = 1;
  for (; button.bit < 16; ++button.bit) reader.button_fields_.push_back(button);
  reader.settle();
  return reader;
}

void AxisReader::settle() noexcept {
  for (AxisPlace& place : places_) {
    const auto low = static_cast<double>(place.field.logical_min);
    const auto high = static_cast<double>(place.field.logical_max);
    place.centre = 0.5 * (low + high);
    place.limit = 0.5 * (high - low);
  }
  for (int report = 0; report < 256; ++report) centre(report);
  heard_.fill(-1);
}

int AxisReader::take(std::span<const std::uint8_t> report) noexcept {
  if (report.empty()) return -1;
  const int id = numbered_ ? report[0] : 0;
  const auto payload = numbered_ ? report.subspan(1) : report;
  bool known = false;
  for (std::size_t axis = 0; axis < kRawAxes; ++axis) {
    const AxisPlace& place = places_[axis];
    if (!place.there || place.field.report != id) continue;
    if (const auto value = get_field(place.field, payload)) {
      counts_[static_cast<Eigen::Index>(axis)] = static_cast<std::int32_t>(*value);
      known = true;
    }
  }
  for (std::size_t k = 0; k < button_fields_.size(); ++k) {
    if (button_fields_[k].report != id) continue;
    if (const auto value = get_field(button_fields_[k], payload)) {
      const std::uint32_t bit = 1u << k;
      buttons_ = *value ? buttons_ | bit : buttons_ & ~bit;
      known = true;
    }
  }
  if (!known) return -1;
  ++reports_;
  repeats_ += std::ranges::equal(report, std::span(last_).first(last_size_));
  last_size_ = std::min(report.size(), last_.size());
  std::copy_n(report.begin(), last_size_, last_.begin());
  return id;
}

bool AxisReader::poll(HidTransport& transport, double t) noexcept {
  std::array<std::uint8_t, 256> report;
  for (int i = 0; i < kMostReports; ++i) {
    const int length = transport.read(report, 0);
    if (length < 0) return false;
    if (length == 0) break;
    const int id = take(std::span(report).first(static_cast<std::size_t>(length)));
    if (id >= 0) heard_[static_cast<std::size_t>(id)] = t;
  }
  return true;
}

bool AxisReader::centre(int report) noexcept {
  bool moved = false;
  for (std::size_t axis = 0; axis < kRawAxes; ++axis) {
    if (!places_[axis].there || places_[axis].field.report != report) continue;
    std::int32_t& count = counts_[static_cast<Eigen::Index>(axis)];
    const auto centre = static_cast<std::int32_t>(places_[axis].centre);
    moved |= count != centre;
    count = centre;
  }
  return moved;
}

int AxisReader::axes() const noexcept {
  return static_cast<int>(
      std::count_if(places_.begin(), places_.end(), [](const AxisPlace& p) { return p.there; }));
}

}  // namespace ferrule
