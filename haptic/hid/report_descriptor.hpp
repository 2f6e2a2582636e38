// What the bytes of a HID device's reports mean: its report descriptor, as a list of fields.
//
// A report is the id's byte and then the payload; devices without ids have one report of each type,
// id 0. Offsets count bits of the payload, the lowest bit of each byte first. A field is a variable
// (one number, with its usage) or an array (each element picks one of the usages: element value
// logical_min + k picks usages[k]). Usages are page << 16 | id.
// Source: USB Device Class Definition for Human Interface Devices 1.11, sections 5 and 6.2.2.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "haptic/trouble.hpp"

namespace ferrule {

enum class HidReportType : std::uint8_t { input, output, feature };

struct HidField {
  HidReportType type = HidReportType::input;
  std::uint8_t report = 0;  // id of its report
  std::uint16_t bit = 0;    // where its first element begins in the payload [bits]
  std::uint8_t size = 0;    // of an element [bits], 1 to 32
  std::uint16_t count = 1;  // elements; 1 for a variable
  bool variable = true;     // or an array
  bool relative = false;    // changes since the last report
  std::int64_t logical_min = 0, logical_max = 0;
  std::int64_t physical_min = 0, physical_max = 0;  // both 0: as the logical range
  std::uint32_t unit = 0;
  int unit_exponent = 0;
  std::vector<std::uint32_t> usages;       // a variable has one at most
  std::vector<std::uint32_t> collections;  // usages of the collections it is in, outermost first
};

struct HidDescriptor {
  std::vector<HidField> fields;  // without constants (padding) and what is wider than 32 bits
  bool numbered = false;         // reports begin with an id
  std::uint32_t usage = 0;       // of the first application collection

  // Payload of a report [bytes]; 0 if there is no such report.
  std::size_t payload(HidReportType type, std::uint8_t report) const noexcept {
    return (bits[static_cast<std::size_t>(type)][report] + 7u) / 8u;
  }
  std::array<std::array<std::uint16_t, 256>, 3> bits{};
};

// Bytes -> fields. Throws DeviceTrouble, naming the byte, if an item is cut off, collections or
// stacked states do not pair, a report is longer than 4 kB, or there are more than 4096 fields or
// bytes. Of an array's usages the first 256 are kept.
HidDescriptor parse_report_descriptor(std::span<const std::uint8_t> bytes);

// The first field of `type` with `usage`, within a collection of usage `collection` (0: anywhere);
// null if there is none.
const HidField* find_field(const HidDescriptor& descriptor, HidReportType type, std::uint32_t usage,
                           std::uint32_t collection = 0) noexcept;

// Has it an input within a collection of usage `collection`?
bool describes(const HidDescriptor& descriptor, std::uint32_t collection) noexcept;

inline constexpr std::uint32_t kMultiAxis = 0x10008;  // usage of a multi-axis controller

// Element `element` of a field in a payload, with its sign where the logical range has one. Empty
// if the payload is too short for it or the field has no such element.
std::optional<std::int64_t> get_field(const HidField& field, std::span<const std::uint8_t> payload,
                                      std::size_t element = 0) noexcept;

// Writes the low bits of `value`; what does not fit into the payload is left out.
void put_field(const HidField& field, std::span<std::uint8_t> payload, std::int64_t value) noexcept;

}  // namespace ferrule
