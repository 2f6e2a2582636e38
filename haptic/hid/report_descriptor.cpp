#include "haptic/hid/report_descriptor.hpp"

#include <algorithm>
#include <string>

namespace ferrule {
namespace {

constexpr std::size_t kMostBytes = 4096, kMostFields = 4096, kMostUsages = 256;
constexpr std::size_t kMostNested = 16;  // collections and pushed states
constexpr std::uint32_t kMostReportBits = 8 * 4096 - 1;

// Items, their size bits taken off.
enum Item : std::uint8_t {
  kInput = 0x80,
  kOutput = 0x90,
  kFeature = 0xB0,
  kCollection = 0xA0,
  kEndCollection = 0xC0,
  kUsagePage = 0x04,
  kLogicalMin = 0x14,
  kLogicalMax = 0x24,
  kPhysicalMin = 0x34,
  kPhysicalMax = 0x44,
  kUnitExponent = 0x54,
  kUnit = 0x64,
  kReportSize = 0x74,
  kReportId = 0x84,
  kReportCount = 0x94,
  kPush = 0xA4,
  kPop = 0xB4,
  kUsage = 0x08,
  kUsageMin = 0x18,
  kUsageMax = 0x28,
  kLongItem = 0xFE,
};
enum Flag : std::uint32_t { kConstantField = 1, kVariable = 2, kRelative = 4 };

struct Value {
  std::uint32_t bits = 0;
  std::int32_t number = 0;  // with sign
};

struct Globals {
  std::uint32_t page = 0, unit = 0, size = 0, count = 0;
  Value logical_min, logical_max, physical_min, physical_max;
  int exponent = 0;
  std::uint8_t report = 0;
};

// Many descriptors write 255 as the byte FF: a maximum below a minimum that is not negative was
// meant without a sign.
std::int64_t maximum(const Value& min, const Value& max) {
  return min.number >= 0 ? std::int64_t{max.bits} : std::int64_t{max.number};
}

class Parser {
 public:
  explicit Parser(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  HidDescriptor run() {
    if (bytes_.size() > kMostBytes) refuse("longer than 4096 bytes");
    while (at_ < bytes_.size()) item();
    if (!collections_.empty()) refuse("a collection is not ended");
    return std::move(result_);
  }

 private:
  [[noreturn]] void refuse(const std::string& what) const {
    throw DeviceTrouble("report descriptor, byte " + std::to_string(at_) + ": " + what);
  }

  void item() {
    const std::uint8_t prefix = bytes_[at_];
    const std::size_t left = bytes_.size() - at_ - 1;
    if (prefix == kLongItem) {
      if (left < 2 || left - 2 < bytes_[at_ + 1]) refuse("the item is cut off");
      at_ += 3u + bytes_[at_ + 1];
      return;
    }
    const std::size_t size = (prefix & 3u) == 3 ? 4 : prefix & 3u;
    if (left < size) refuse("the item is cut off");
    Value value;
    for (std::size_t i = 0; i < size; ++i)
      value.bits |= std::uint32_t{bytes_[at_ + 1 + i]} << (8 * i);
    value.number = size == 1   ? static_cast<std::int8_t>(value.bits)
                   : size == 2 ? static_cast<std::int16_t>(value.bits)
                               : static_cast<std::int32_t>(value.bits);
    take(static_cast<std::uint8_t>(prefix & 0xFCu), value, size);
    at_ += 1 + size;
  }

  void take(std::uint8_t item, const Value& value, std::size_t size) {
    take_main(item, value);
    take_global(item, value);
    take_local(item, value, size);
  }

  void take_main(std::uint8_t item, const Value& value) {
    switch (item) {
      case kInput:
        return main_item(HidReportType::input, value.bits);
      case kOutput:
        return main_item(HidReportType::output, value.bits);
      case kFeature:
        return main_item(HidReportType::feature, value.bits);
      case kCollection:
        return begin_collection(value.bits);
      case kEndCollection:
        if (collections_.empty()) refuse("no collection to end");
        collections_.pop_back();
        return forget_usages();
      default:
        return;
    }
  }

  void take_global(std::uint8_t item, const Value& value) {
    switch (item) {
      case kUsagePage:
        g_.page = value.bits & 0xFFFFu;
        return;
      case kLogicalMin:
        g_.logical_min = value;
        return;
      case kLogicalMax:
        g_.logical_max = value;
        return;
      case kPhysicalMin:
        g_.physical_min = value;
        return;
      case kPhysicalMax:
        g_.physical_max = value;
        return;
      // Four bits with a sign; some write it as a byte with a sign, which has the same low bits.
      case kUnitExponent:
        g_.exponent = static_cast<int>((value.bits & 15u) ^ 8u) - 8;
        return;
      case kUnit:
        g_.unit = value.bits;
        return;
      case kReportSize:
        g_.size = value.bits;
        return;
      case kReportCount:
        g_.count = value.bits;
        return;
      case kReportId:
        if (value.bits == 0 || value.bits > 255) refuse("a report id must be 1 to 255");
        g_.report = static_cast<std::uint8_t>(value.bits);
        result_.numbered = true;
        return;
      case kPush:
        if (stack_.size() == kMostNested) refuse("too many pushed states");
        stack_.push_back(g_);
        return;
      case kPop:
        if (stack_.empty()) refuse("no pushed state to pop");
        g_ = stack_.back();
        stack_.pop_back();
        return;
      default:
        return;
    }
  }

  void take_local(std::uint8_t item, const Value& value, std::size_t size) {
    switch (item) {
      case kUsage:
        add_usage(full(value, size));
        return;
      case kUsageMin:
        usage_min_ = full(value, size);
        return range();
      case kUsageMax:
        usage_max_ = full(value, size);
        return range();
      default:
        return;  // designators, strings, reserved items
    }
  }

  std::uint32_t full(const Value& usage, std::size_t size) const {
    return size == 4 ? usage.bits : g_.page << 16 | usage.bits;
  }
  void add_usage(std::uint32_t usage) {
    if (usages_.size() < kMostUsages) usages_.push_back(usage);
  }
  void range() {
    if (!usage_min_ || !usage_max_) return;
    for (std::uint64_t u = *usage_min_; u <= *usage_max_ && usages_.size() < kMostUsages; ++u)
      usages_.push_back(static_cast<std::uint32_t>(u));
    usage_min_ = usage_max_ = std::nullopt;
  }
  void forget_usages() {
    usages_.clear();
    usage_min_ = usage_max_ = std::nullopt;
  }

  void begin_collection(std::uint32_t kind) {
    if (collections_.size() == kMostNested) refuse("collections are nested too deeply");
    const std::uint32_t usage = usages_.empty() ? 0 : usages_.front();
    if (kind == 1 && result_.usage == 0) result_.usage = usage;
    collections_.push_back(usage);
    forget_usages();
  }

  void main_item(HidReportType type, std::uint32_t flags) {
    std::uint16_t& end = result_.bits[static_cast<std::size_t>(type)][g_.report];
    const std::uint64_t length = std::uint64_t{g_.size} * g_.count;
    if (end + length > kMostReportBits) refuse("a report is longer than 4 kB");
    if (length > 0 && !(flags & kConstantField)) add_fields(type, flags, end);
    end = static_cast<std::uint16_t>(end + length);
    forget_usages();
  }

  void add_fields(HidReportType type, std::uint32_t flags, std::uint16_t begin) {
    if (g_.size > 32) return;  // makers' own, as 64-bit words
    HidField field;
    field.type = type;
    field.report = g_.report;
    field.bit = begin;
    field.size = static_cast<std::uint8_t>(g_.size);
    field.variable = flags & kVariable;
    field.relative = flags & kRelative;
    field.logical_min = g_.logical_min.number;
    field.logical_max = maximum(g_.logical_min, g_.logical_max);
    field.physical_min = g_.physical_min.number;
    field.physical_max = maximum(g_.physical_min, g_.physical_max);
    field.unit = g_.unit;
    field.unit_exponent = g_.exponent;
    field.collections = collections_;
    const std::size_t fields = field.variable ? g_.count : 1;
    if (result_.fields.size() + fields > kMostFields) refuse("more than 4096 fields");
    if (!field.variable) {
      field.count = static_cast<std::uint16_t>(g_.count);
      field.usages = usages_;
      result_.fields.push_back(field);
      return;
    }
    for (std::size_t i = 0; i < fields; ++i) {  // the last usage serves all that follow
      if (!usages_.empty()) field.usages = {usages_[std::min(i, usages_.size() - 1)]};
      result_.fields.push_back(field);
      field.bit = static_cast<std::uint16_t>(field.bit + g_.size);
    }
  }

  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
  Globals g_;
  std::vector<Globals> stack_;
  std::vector<std::uint32_t> usages_, collections_;
  std::optional<std::uint32_t> usage_min_, usage_max_;
  HidDescriptor result_;
};

}  // namespace

HidDescriptor parse_report_descriptor(std::span<const std::uint8_t> bytes) {
  return Parser(bytes).run();
}

const HidField* find_field(const HidDescriptor& descriptor, HidReportType type, std::uint32_t usage,
                           std::uint32_t collection) noexcept {
  const auto has = [](const std::vector<std::uint32_t>& list, std::uint32_t wanted) {
    return std::find(list.begin(), list.end(), wanted) != list.end();
  };
  for (const HidField& field : descriptor.fields)
    if (field.type == type && has(field.usages, usage) &&
        (collection == 0 || has(field.collections, collection)))
      return &field;
  return nullptr;
}

bool describes(const HidDescriptor& descriptor, std::uint32_t collection) noexcept {
  const auto inside = [&](const HidField& field) {
    return field.type == HidReportType::input &&
           std::find(field.collections.begin(), field.collections.end(), collection) !=
               field.collections.end();
  };
  return std::any_of(descriptor.fields.begin(), descriptor.fields.end(), inside);
}

std::optional<std::int64_t> get_field(const HidField& field, std::span<const std::uint8_t> payload,
                                      std::size_t element) noexcept {
  const std::size_t begin = field.bit + element * field.size;
  if (element >= field.count || begin + field.size > 8 * payload.size()) return std::nullopt;
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < field.size; ++i) {
    const std::size_t bit = begin + i;
    bits |= std::uint64_t{payload[bit / 8] >> (bit % 8) & 1u} << i;
  }
  auto value = static_cast<std::int64_t>(bits);
  if (field.logical_min < 0 && (bits >> (field.size - 1) & 1u))
    value -= std::int64_t{1} << field.size;
  return value;
}

void put_field(const HidField& field, std::span<std::uint8_t> payload,
               std::int64_t value) noexcept {
  for (std::size_t i = 0; i < field.size; ++i) {
    const std::size_t bit = field.bit + i;
    if (bit >= 8 * payload.size()) return;
    const auto mask = static_cast<std::uint8_t>(1u << (bit % 8));
    std::uint8_t& byte = payload[bit / 8];
    byte = static_cast<std::uint8_t>(value >> i & 1 ? byte | mask : byte & ~mask);
  }
}

}  // namespace ferrule
