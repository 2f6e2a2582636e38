#include "haptic/hid/fake_firmware.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <numbers>

#include "sim/base/elementary.hpp"

namespace ferrule {
namespace {

constexpr double kMousePeriod = 8e-3, kStickPeriod = 1e-3;  // between reports [s]
constexpr std::size_t kMostWaiting = 64;                    // as the kernel keeps for a reader

using enum HidReportType;

// Writes a report descriptor, item by item.
class Describe {
 public:
  Describe& item(std::uint8_t prefix, std::int64_t value) {
    const int size = value == 0                         ? 1
                     : value >= -128 && value < 128     ? 1
                     : value >= -32768 && value < 32768 ? 2
                                                        : 4;
    bytes_.push_back(static_cast<std::uint8_t>(prefix | (size == 4 ? 3 : size)));
    for (int i = 0; i < size; ++i) bytes_.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
    return *this;
  }
  Describe& usage(std::uint32_t usage) {  // page << 16 | id
    item(0x04, usage >> 16);
    return item(0x08, usage & 0xFFFF);
  }
  Describe& begin(int kind, std::uint32_t of) { return usage(of).item(0xA0, kind); }
  Describe& begin_report(std::uint32_t of, int id) { return begin(2, of).item(0x84, id); }
  Describe& end() {
    bytes_.push_back(0xC0);
    return *this;
  }
  Describe& numbers(HidReportType type, std::initializer_list<std::uint32_t> usages,
                    std::int64_t low, std::int64_t high, int bits) {
    for (const std::uint32_t u : usages) usage(u);
    return range(low, high).main(type, 2, bits, static_cast<int>(usages.size()));
  }
  Describe& choice(HidReportType type, std::initializer_list<std::uint32_t> usages) {
    for (const std::uint32_t u : usages) usage(u);
    return range(1, static_cast<std::int64_t>(usages.size())).main(type, 0, 8, 1);
  }
  Describe& padding(HidReportType type, int bits) { return main(type, 3, bits, 1); }
  Describe& range(std::int64_t low, std::int64_t high) {
    item(0x14, low).item(0x24, high);
    return item(0x34, low).item(0x44, high);
  }
  Describe& seconds(int exponent) { return item(0x64, 0x1003).item(0x54, exponent & 15); }
  Describe& no_unit() { return item(0x64, 0).item(0x54, 0); }
  Describe& main(HidReportType type, int flags, int bits, int count) {
    item(0x74, bits).item(0x94, count);
    return item(type == input ? 0x80 : type == output ? 0x90 : 0xB0, flags);
  }
  std::vector<std::uint8_t> bytes() { return std::move(bytes_); }

 private:
  std::vector<std::uint8_t> bytes_;
};

std::vector<std::uint8_t> space_mouse_descriptor(bool combined) {
  Describe d;
  d.begin(1, 0x10008).begin(0, 0x10001).item(0x84, 1);
  d.numbers(input, {0x10030, 0x10031, 0x10032}, -350, 350, 16);
  if (!combined) d.item(0x84, 2);
  d.numbers(input, {0x10033, 0x10034, 0x10035}, -350, 350, 16).end();
  d.item(0x84, 3).item(0x04, 9).item(0x18, 1).item(0x28, 2);
  d.range(0, 1).main(input, 2, 1, 2).padding(input, 14);
  d.item(0x84, 4).numbers(output, {0x8004B}, 0, 1, 1).padding(output, 7);
  return d.end().bytes();
}

// Ids of the reports of the two layouts.
struct PidIds {
  int state, set_effect, constant, operation, free, control, gain, create, load, pool;
};
constexpr PidIds kIds18 = {2, 1, 5, 10, 11, 12, 13, 5, 6, 7};
constexpr PidIds kIds22 = {0x12, 0x11, 0x15, 0x1A, 0x1B, 0x1C, 0x1D, 0x21, 0x22, 0x23};

std::vector<std::uint8_t> pid_descriptor(bool wide) {
  const PidIds& id = wide ? kIds22 : kIds18;
  const std::initializer_list<std::uint32_t> kTypes = {0xF0026, 0xF0027, 0xF0030, 0xF0031,
                                                       0xF0040, 0xF0041, 0xF0043};
  Describe d;
  d.begin(1, 0x10004).begin(0, 0x10001).item(0x84, 1);
  d.numbers(input, {0x10030, 0x10031, 0x10032}, -32767, 32767, 16);
  d.item(0x04, 9).item(0x18, 1).item(0x28, 8).range(0, 1).main(input, 2, 1, 8).end();

  d.begin_report(0xF0092, id.state);
  d.numbers(input, {0xF009F, 0xF00A0, 0xF00A4, 0xF00A5, 0xF00A6}, 0, 1, 1).padding(input, 3);
  d.numbers(input, {0xF0094}, 0, 1, 1).numbers(input, {0xF0022}, 1, 40, 7).end();

  d.begin_report(0xF0021, id.set_effect).numbers(output, {0xF0022}, 1, 40, 8);
  d.begin(2, 0xF0025).choice(output, kTypes).end().seconds(-3);
  if (wide)
    d.numbers(output, {0xF0050, 0xF0054, 0xF0051, 0xF00A7}, 0, 32767, 16);
  else
    d.numbers(output, {0xF0050, 0xF0054, 0xF0051}, 0, 32767, 16);
  d.no_unit().numbers(output, {0xF0052}, 0, 255, 8).numbers(output, {0xF0053}, 1, 8, 8);
  d.begin(2, 0xF0055).numbers(output, {0x10030, 0x10031}, 0, 1, 1).end();
  d.numbers(output, {0xF0056}, 0, 1, 1).padding(output, 5);
  d.begin(2, 0xF0057).numbers(output, {0xA0001, 0xA0002}, 0, wide ? 36000 : 255, wide ? 16 : 8);
  d.end().begin(2, 0xF0058).numbers(output, {0xA0001, 0xA0002}, 0, 32765, 16).end().end();

  d.begin_report(0xF0073, id.constant).numbers(output, {0xF0022}, 1, 40, 8);
  d.numbers(output, {0xF0070}, wide ? -32768 : -10000, wide ? 32767 : 10000, 16).end();

  d.begin_report(0xF0077, id.operation).numbers(output, {0xF0022}, 1, 40, 8);
  d.begin(2, 0xF0078).choice(output, {0xF0079, 0xF007A, 0xF007B}).end();
  d.numbers(output, {0xF007C}, 0, 255, 8).end();

  d.begin_report(0xF0090, id.free).numbers(output, {0xF0022}, 1, 40, 8).end();

  d.begin_report(0xF0096, id.control);
  for (std::uint32_t u = 0xF0097; u <= 0xF009C; ++u) d.usage(u);
  // The mask with the range of the array, as devices have it.
  d.range(1, 6).main(output, wide ? 2 : 0, wide ? 1 : 8, wide ? 8 : 1).end();

  d.begin_report(0xF007D, id.gain).numbers(output, {0xF007E}, 0, 255, 8).end();

  d.begin_report(0xF00AB, id.create).begin(2, 0xF0025).choice(feature, kTypes).end();
  d.numbers(feature, {0x1003B}, 0, 511, 10).padding(feature, 6).end();
  d.begin_report(0xF0089, id.load).numbers(feature, {0xF0022}, 1, 40, 8);
  d.begin(2, 0xF008B).choice(feature, {0xF008C, 0xF008D, 0xF008E}).end();
  d.numbers(feature, {0xF00AC}, 0, 65535, 16).end();
  d.begin_report(0xF007F, id.pool).numbers(feature, {0xF0080}, 0, 65535, 16);
  d.numbers(feature, {0xF0083}, 0, 255, 8).end();
  return d.end().bytes();
}

int word(std::span<const std::uint8_t> r, std::size_t at) noexcept {
  return r[at] | r[at + 1] << 8;
}
int signed_word(std::span<const std::uint8_t> r, std::size_t at) noexcept {
  return static_cast<std::int16_t>(word(r, at));
}

void append(std::vector<std::uint8_t>& report, int number) {
  report.push_back(static_cast<std::uint8_t>(number));
  report.push_back(static_cast<std::uint8_t>(number >> 8));
}

}  // namespace

HidInfo FakeFirmware::describe(FakeModel model) {
  switch (model) {
    case FakeModel::space_mouse_split:
      return {"fake:spacemouse",
              0x256f,
              0xc635,
              1,
              8,
              "fake SpaceMouse, split reports",
              space_mouse_descriptor(false)};
    case FakeModel::space_mouse_combined:
      return {
          "fake:spacemouse",           0x256f, 0xc63a, 1, 8, "fake SpaceMouse, combined reports",
          space_mouse_descriptor(true)};
    case FakeModel::pid_18:
      return {
          "fake:pid",           0x1209, 0x0018, 1, 4, "fake force stick, Set Effect of 18 bytes",
          pid_descriptor(false)};
    case FakeModel::pid_22:
      break;
  }
  return {"fake:pid",          0x1209, 0x0022, 1, 4, "fake force stick, Set Effect of 22 bytes",
          pid_descriptor(true)};
}

FakeFirmware::FakeFirmware(FakeModel model, int effects)
    : FakeTransport(describe(model)),
      model_(model),
      effects_(is_stick() ? static_cast<std::size_t>(effects) : 0) {}

bool FakeFirmware::is_stick() const noexcept {
  return model_ == FakeModel::pid_18 || model_ == FakeModel::pid_22;
}

int FakeFirmware::read(std::span<std::uint8_t> report, int) noexcept {
  if (unplugged_) return -1;
  if (waiting_.empty()) return 0;
  const std::size_t length = std::min(report.size(), waiting_.front().size());
  std::copy_n(waiting_.front().begin(), length, report.begin());
  waiting_.pop_front();
  return static_cast<int>(length);
}

bool FakeFirmware::write(std::span<const std::uint8_t> report) noexcept {
  if (unplugged_ || report.empty()) return false;
  log_.push_back({output, {report.begin(), report.end()}});
  return take_output(report);
}

bool FakeFirmware::send_feature(std::span<const std::uint8_t> r) noexcept {
  if (unplugged_ || r.empty()) return false;
  log_.push_back({feature, {r.begin(), r.end()}});
  const PidIds& id = model_ == FakeModel::pid_22 ? kIds22 : kIds18;
  if (!is_stick() || r[0] != id.create || r.size() != 4 || r[1] == 0) return false;
  loaded_ = 0;
  for (std::size_t i = 0; i < effects_.size() && !loaded_; ++i)
    if (!effects_[i].used) {
      effects_[i] = {};
      effects_[i].used = true;
      effects_[i].constant = r[1] == 1;
      loaded_ = static_cast<int>(i) + 1;
    }
  return true;
}

int FakeFirmware::get_feature(std::span<std::uint8_t> r) noexcept {
  const PidIds& id = model_ == FakeModel::pid_22 ? kIds22 : kIds18;
  if (unplugged_ || !is_stick() || r.size() < 5 || r[0] != id.load) return -1;
  r[1] = static_cast<std::uint8_t>(loaded_);
  r[2] = loaded_ ? 1 : 2;  // success, full
  r[3] = r[4] = 0xFF;      // memory that is left
  return 5;
}

bool FakeFirmware::take_output(std::span<const std::uint8_t> r) noexcept {
  if (!is_stick()) {
    if (r[0] != 4 || r.size() != 2) return false;
    light_ = r[1] & 1;
    return true;
  }
  const bool wide = model_ == FakeModel::pid_22;
  const PidIds& id = wide ? kIds22 : kIds18;
  if (r[0] == id.control && r.size() == 2) {
    if (!wide) return control(r[1]);
    for (int bit = 0; bit < 6; ++bit)
      if (r[1] == 1 << bit) return control(bit + 1);
    return false;
  }
  if (r[0] == id.gain) return r.size() == 2;
  Effect* const e = r.size() > 1 ? effect(r[1]) : nullptr;
  if (!e) return false;
  if (r[0] == id.free && r.size() == 2) {
    *e = {};
  } else if (r[0] == id.constant && r.size() == 4) {
    const int magnitude = signed_word(r, 2);
    e->force = magnitude / (!wide ? 10000.0 : magnitude < 0 ? 32768.0 : 32767.0);
    return std::abs(e->force) <= 1;
  } else if (r[0] == id.operation && r.size() == 4) {
    if (r[2] < 1 || r[2] > 3) return false;
    e->until = r[2] == 3 ? -1 : time_ + e->duration * r[3];
  } else if (r[0] == id.set_effect && r.size() == (wide ? 22 : 18)) {
    const std::size_t after_times = wide ? 11 : 9;
    e->duration = 1e-3 * word(r, 3);
    e->gain = r[after_times] / 255.0;
    const std::size_t direction = after_times + 3;
    e->angle = !(r[after_times + 2] & 4) ? 0.25
               : wide                    ? word(r, direction) / 36000.0
                                         : r[direction] / 255.0;
    return r[2] == 1;
  } else {
    return false;
  }
  return true;
}

bool FakeFirmware::control(int what) noexcept {
  if (what == 1) enabled_ = true;
  if (what == 2) enabled_ = false;
  if (what == 3)
    for (Effect& e : effects_) e.until = -1;
  if (what == 4) reset();
  return what >= 1 && what <= 6;
}

void FakeFirmware::reset() noexcept {
  std::fill(effects_.begin(), effects_.end(), Effect{});
  enabled_ = false;
}

FakeFirmware::Effect* FakeFirmware::effect(int block) noexcept {
  if (block < 1 || block > static_cast<int>(effects_.size())) return nullptr;
  Effect& e = effects_[static_cast<std::size_t>(block) - 1];
  return e.used ? &e : nullptr;
}

int FakeFirmware::effects() const noexcept {
  return static_cast<int>(
      std::count_if(effects_.begin(), effects_.end(), [](const Effect& e) { return e.used; }));
}

std::array<double, 2> FakeFirmware::force() const noexcept {
  std::array<double, 2> sum{};
  for (const Effect& e : effects_) {
    if (!enabled_ || !e.constant || time_ >= e.until) continue;
    sum[0] += e.gain * e.force * elementary::sin(2 * std::numbers::pi * e.angle);
    sum[1] -= e.gain * e.force * elementary::cos(2 * std::numbers::pi * e.angle);
  }
  return sum;
}

void FakeFirmware::press(std::uint8_t buttons) {
  if (buttons == buttons_) return;
  buttons_ = buttons;
  if (!is_stick()) send({3, buttons, 0});
}

void FakeFirmware::advance(double t) {
  for (; next_report_ <= t; next_report_ += is_stick() ? kStickPeriod : kMousePeriod) {
    time_ = next_report_;
    send_axes();
  }
  time_ = std::max(time_, t);
}

void FakeFirmware::send(std::vector<std::uint8_t> report) {
  if (silent_ || unplugged_) return;
  if (waiting_.size() == kMostWaiting) waiting_.pop_front();
  waiting_.push_back(std::move(report));
}

void FakeFirmware::send_axes() {
  std::vector<std::uint8_t> report = {1};
  if (is_stick()) {
    for (int axis = 0; axis < 3; ++axis) append(report, counts_[static_cast<std::size_t>(axis)]);
    report.push_back(buttons_);
    return send(std::move(report));
  }
  const bool split = model_ == FakeModel::space_mouse_split;
  const bool deflected = std::any_of(counts_.begin(), counts_.end(), [](int c) { return c != 0; });
  if (deflected) zeros_ = split ? 6 : 3;
  if (zeros_ == 0) return;
  if (!deflected) --zeros_;
  const std::size_t first = split && second_ ? 3 : 0;
  report[0] = first ? 2 : 1;
  for (std::size_t axis = first; axis < (split ? first + 3 : 6); ++axis)
    append(report, counts_[axis]);
  second_ = !second_;
  send(std::move(report));
}

}  // namespace ferrule
