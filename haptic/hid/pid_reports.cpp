#include "haptic/hid/pid_reports.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

namespace ferrule {
namespace {

using enum HidReportType;

// Usages of page 0x0F, and of others that its reports use.
enum Usage : std::uint32_t {
  kSetEffect = 0xF0021,
  kBlockIndex = 0xF0022,
  kEffectType = 0xF0025,
  kConstant = 0xF0026,
  kDuration = 0xF0050,
  kGain = 0xF0052,
  kAxesEnable = 0xF0055,
  kDirectionEnable = 0xF0056,
  kDirection = 0xF0057,
  kMagnitude = 0xF0070,
  kSetConstantForce = 0xF0073,
  kEffectOperation = 0xF0077,
  kStart = 0xF0079,
  kStop = 0xF007B,
  kLoopCount = 0xF007C,
  kDeviceGainReport = 0xF007D,
  kDeviceGain = 0xF007E,
  kBlockLoad = 0xF0089,
  kSuccess = 0xF008C,
  kFull = 0xF008D,
  kBlockFree = 0xF0090,
  kDeviceControl = 0xF0096,
  kEnable = 0xF0097,
  kDisable = 0xF0098,
  kStopAll = 0xF0099,
  kReset = 0xF009A,
  kCreateNewEffect = 0xF00AB,
  kX = 0x10030,
  kY = 0x10031,
  kInstance1 = 0xA0001,
};

constexpr std::uint32_t kSeconds[] = {0x1001, 0x1003};  // SI and English linear units of time

// Of a field that may be narrower than its declared range.
double cut(const HidField& field, double value) noexcept {
  const double widest = std::ldexp(1.0, field.size);
  const double low = field.logical_min < 0 ? -widest / 2 : 0;
  const double high = (field.logical_min < 0 ? widest / 2 : widest) - 1;
  value = std::clamp(
      value, static_cast<double>(field.logical_min),
      std::max(static_cast<double>(field.logical_max), static_cast<double>(field.logical_min)));
  return std::clamp(value, low, high);
}

bool in_collection(const HidField& field, std::uint32_t usage) noexcept {
  return std::find(field.collections.begin(), field.collections.end(), usage) !=
         field.collections.end();
}

// Counts of a time field in one second.
double per_second(const HidField& field) noexcept {
  const bool seconds =
      std::find(std::begin(kSeconds), std::end(kSeconds), field.unit) != std::end(kSeconds);
  const int exponent = seconds ? -field.unit_exponent : 3;
  double power = 1;
  for (int i = 0; i < std::abs(exponent); ++i) power *= 10;
  const double scale = exponent < 0 ? 1 / power : power;
  const double physical = static_cast<double>(field.physical_max - field.physical_min);
  const double logical = static_cast<double>(field.logical_max - field.logical_min);
  return seconds && physical > 0 ? scale * logical / physical : scale;
}

}  // namespace

bool PidReports::in(const HidDescriptor& descriptor) noexcept {
  return find_field(descriptor, output, kMagnitude, kSetConstantForce);
}

PidReports::PidReports(const HidDescriptor& descriptor) : descriptor_(descriptor) {
  const auto need = [&](HidReportType type, std::uint32_t usage, std::uint32_t collection,
                        const char* name) {
    const HidField* field = find_field(descriptor_, type, usage, collection);
    if (!field)
      throw DeviceTrouble(std::string("its report descriptor has no ") + name +
                          ", which force feedback needs");
    if (descriptor_.payload(type, field->report) > 64)
      throw DeviceTrouble(std::string("its report with ") + name + " is longer than 64 bytes");
    return field->report;
  };
  create_ = need(feature, kConstant, kCreateNewEffect, "Create New Effect (constant)");
  need(feature, kBlockIndex, kBlockLoad, "Block Load index");
  load_ = need(feature, kSuccess, kBlockLoad, "Block Load status");
  need(output, kBlockIndex, kSetEffect, "Set Effect block index");
  need(output, kConstant, kSetEffect, "Set Effect type");
  set_effect_ = need(output, kDuration, kSetEffect, "Set Effect duration");
  need(output, kBlockIndex, kSetConstantForce, "Set Constant Force block index");
  constant_ = need(output, kMagnitude, kSetConstantForce, "Set Constant Force magnitude");
  need(output, kBlockIndex, kEffectOperation, "Effect Operation block index");
  need(output, kStop, kEffectOperation, "Effect Operation stop");
  operation_ = need(output, kStart, kEffectOperation, "Effect Operation start");
  need(output, kDisable, kDeviceControl, "Device Control disable");
  need(output, kStopAll, kDeviceControl, "Device Control stop all");
  control_ = need(output, kEnable, kDeviceControl, "Device Control enable");
  if (find_field(descriptor_, output, kY, kAxesEnable)) axes_ = 2;
}

HidReport PidReports::blank(HidReportType type, std::uint8_t id) const noexcept {
  HidReport report;
  report.size = 1 + std::min<std::size_t>(64, descriptor_.payload(type, id));
  report.bytes[0] = id;
  for (const HidField& field : descriptor_.fields)
    if (field.type == type && field.report == id && field.variable)
      put_field(field, report.span().subspan(1), std::llround(cut(field, 0)));
  return report;
}

void PidReports::choose(HidReport& report, HidReportType type, std::uint32_t collection,
                        std::uint32_t usage) const noexcept {
  const HidField* field = find_field(descriptor_, type, usage, collection);
  if (!field || field->report != report.bytes[0]) return;
  const auto at = std::find(field->usages.begin(), field->usages.end(), usage);
  const std::int64_t element = field->logical_min + (at - field->usages.begin());
  put_field(*field, report.span().subspan(1), field->variable ? 1 : element);
}

void PidReports::put(HidReport& report, HidReportType type, std::uint32_t collection,
                     std::uint32_t usage, double value) const noexcept {
  const HidField* field = find_field(descriptor_, type, usage, collection);
  if (field && field->report == report.bytes[0])
    put_field(*field, report.span().subspan(1), std::llround(cut(*field, value)));
}

HidReport PidReports::create_constant() const noexcept {
  HidReport report = blank(feature, create_);
  choose(report, feature, kCreateNewEffect, kConstant);
  return report;
}

HidReport PidReports::block_load_request() const noexcept {
  HidReport report;
  report.size = 1 + descriptor_.payload(feature, load_);
  report.bytes[0] = load_;
  return report;
}

PidBlockLoad PidReports::block_load(std::span<const std::uint8_t> report) const noexcept {
  using Status = PidBlockLoad::Status;
  constexpr PidBlockLoad kError = {Status::error, 0};
  if (report.empty() || report[0] != load_) return kError;
  const auto payload = report.subspan(1);
  const auto is = [&](std::uint32_t usage) {
    const HidField* field = find_field(descriptor_, feature, usage, kBlockLoad);
    if (!field) return false;
    const auto at = std::find(field->usages.begin(), field->usages.end(), usage);
    const auto value = get_field(*field, payload);
    return value &&
           *value == (field->variable ? 1 : field->logical_min + (at - field->usages.begin()));
  };
  if (is(kFull)) return {Status::full, 0};
  const auto block = get_field(*find_field(descriptor_, feature, kBlockIndex, kBlockLoad), payload);
  if (!is(kSuccess) || !block || *block <= 0) return kError;
  return {Status::success, static_cast<int>(*block)};
}

double PidReports::said_duration(double duration) const noexcept {
  const HidField& time = *find_field(descriptor_, output, kDuration, kSetEffect);
  const double per = per_second(time);
  return static_cast<double>(std::llround(cut(time, duration * per))) / per;
}

HidReport PidReports::set_effect(int block, int axis, double duration) const noexcept {
  HidReport report = blank(output, set_effect_);
  choose(report, output, kSetEffect, kConstant);
  put(report, output, kSetEffect, kBlockIndex, block);
  const HidField& time = *find_field(descriptor_, output, kDuration, kSetEffect);
  put(report, output, kSetEffect, kDuration, duration * per_second(time));
  put(report, output, kSetEffect, kGain, 1e300);  // the end of its range
  const auto direction =
      std::find_if(descriptor_.fields.begin(), descriptor_.fields.end(), [](const HidField& field) {
        return field.type == output && in_collection(field, kDirection) &&
               in_collection(field, kSetEffect);
      });
  if (direction == descriptor_.fields.end()) {
    put(report, output, kAxesEnable, axis == 0 ? kX : kY, 1);
    return report;
  }
  put(report, output, kSetEffect, kDirectionEnable, 1);
  const double turn = static_cast<double>(direction->logical_max - direction->logical_min);
  const double counts = static_cast<double>(direction->logical_min) + turn * (1 + axis) / 4;
  put_field(*direction, report.span().subspan(1), std::llround(cut(*direction, counts)));
  return report;
}

HidReport PidReports::set_constant_force(int block, double force) const noexcept {
  HidReport report = blank(output, constant_);
  put(report, output, kSetConstantForce, kBlockIndex, block);
  const HidField& field = *find_field(descriptor_, output, kMagnitude, kSetConstantForce);
  const double part = std::isfinite(force) ? std::clamp(force, -1.0, 1.0) : 0.0;
  const double end = static_cast<double>(part < 0 ? -field.logical_min : field.logical_max);
  put(report, output, kSetConstantForce, kMagnitude, part * end);
  return report;
}

HidReport PidReports::operation(int block, PidOperation operation) const noexcept {
  HidReport report = blank(output, operation_);
  const bool start = operation == PidOperation::start;
  put(report, output, kEffectOperation, kBlockIndex, block);
  choose(report, output, kEffectOperation, start ? kStart : kStop);
  put(report, output, kEffectOperation, kLoopCount, start ? 1 : 0);
  return report;
}

HidReport PidReports::control(PidControl control) const noexcept {
  HidReport report;
  report.size = 1 + descriptor_.payload(output, control_);
  report.bytes[0] = control_;
  constexpr std::uint32_t kUsages[] = {kEnable, kDisable, kStopAll, kReset};
  choose(report, output, kDeviceControl, kUsages[static_cast<std::size_t>(control)]);
  return report;
}

std::optional<HidReport> PidReports::block_free(int block) const noexcept {
  const HidField* field = find_field(descriptor_, output, kBlockIndex, kBlockFree);
  if (!field) return std::nullopt;
  HidReport report = blank(output, field->report);
  put(report, output, kBlockFree, kBlockIndex, block);
  return report;
}

std::optional<HidReport> PidReports::full_device_gain() const noexcept {
  const HidField* field = find_field(descriptor_, output, kDeviceGain, kDeviceGainReport);
  if (!field) return std::nullopt;
  HidReport report = blank(output, field->report);
  put(report, output, kDeviceGainReport, kDeviceGain, 1e300);
  return report;
}

}  // namespace ferrule
