#include "haptic/hid/space_mouse.hpp"

#include <algorithm>

#include "haptic/hid/fake_firmware.hpp"

namespace ferrule {
namespace {

constexpr std::uint16_t kLogitech = 0x046d, k3Dconnexion = 0x256f;
// Cross-talk between the axes of a resting hand [-]; assumed.
constexpr double kDeadZone = 0.05;

constexpr std::uint16_t kSplit046d[] = {0xc625, 0xc626, 0xc627, 0xc628, 0xc629, 0xc62b};
constexpr std::uint16_t kSplit256f[] = {0xc635, 0xc636, 0xc641};
constexpr std::uint16_t kCombined256f[] = {0xc62e, 0xc62f, 0xc631, 0xc632,
                                           0xc633, 0xc638, 0xc63a, 0xc652};
constexpr std::uint16_t kNever256f[] = {0xc62c, 0xc650, 0xc651, 0xc654, 0xc655, 0xc656,
                                        0xc657, 0xc658, 0xc664, 0xc665, 0xc668};

constexpr std::uint8_t kLightOn[] = {0x04, 0x01}, kLightOff[] = {0x04, 0x00};

template <std::size_t N>
bool among(const std::uint16_t (&list)[N], std::uint16_t product) noexcept {
  return std::find(std::begin(list), std::end(list), product) != std::end(list);
}

}  // namespace

std::optional<SpaceMouseLayout> space_mouse_layout(std::uint16_t vendor,
                                                   std::uint16_t product) noexcept {
  if ((vendor == kLogitech && among(kSplit046d, product)) ||
      (vendor == k3Dconnexion && among(kSplit256f, product)))
    return SpaceMouseLayout::split;
  if (vendor == k3Dconnexion && among(kCombined256f, product)) return SpaceMouseLayout::combined;
  return std::nullopt;
}

bool never_a_space_mouse(std::uint16_t vendor, std::uint16_t product) noexcept {
  return vendor == k3Dconnexion && among(kNever256f, product);
}

AxisReader space_mouse_axes(const HidInfo& info) {
  if (!info.descriptor.empty()) {
    try {
      AxisReader reader(parse_report_descriptor(info.descriptor));
      if (reader.axes() == static_cast<int>(kRawAxes)) return reader;
    } catch (const DeviceTrouble&) {
      // The table may still know it.
    }
  }
  const auto layout = space_mouse_layout(info.vendor, info.product);
  if (!layout) throw DeviceTrouble(info.path + ": its report descriptor names no six axes");
  return AxisReader::space_mouse(*layout == SpaceMouseLayout::combined);
}

Mapping space_mouse_mapping(const AxisReader& axes, double speed, double tilt_rate) noexcept {
  Mapping m;
  m.kind = Mapping::Kind::velocity;
  m.dead_zone = kDeadZone;
  for (std::size_t axis = 0; axis < kRawAxes; ++axis) {
    m.centre[axis] = axes.places()[axis].centre;
    m.limit[axis] = axes.places()[axis].limit;
  }
  // X to the right, Y to the operator, Z down; turns are right-handed about them (assumed).
  m.gain(0, 0) = speed;
  m.gain(1, 2) = -speed;
  m.gain(2, 1) = speed;
  m.gain(3, 4) = tilt_rate;
  m.gain(4, 5) = tilt_rate;
  return m;
}

SpaceMouse::SpaceMouse(HidTransport& transport, double speed, double tilt_rate,
                       const HandPose& start)
    : transport_(transport),
      axes_(space_mouse_axes(transport.info())),
      mapping_(space_mouse_mapping(axes_, speed, tilt_rate)),
      pose_(start) {
  transport_.write(kLightOn);  // not every model has one
  lost_ = !axes_.poll(transport_, 0);
  held_ = axes_.buttons();
}

SpaceMouse::~SpaceMouse() {
  transport_.write(kLightOff);
}

HandSample SpaceMouse::read(double t) {
  pose_ += rate_ * (t - time_);
  time_ = t;
  lost_ = lost_ || !axes_.poll(transport_, t);
  for (const AxisPlace& place : axes_.places()) {
    if (!place.there) continue;
    const int report = place.field.report;
    if (lost_ || t - axes_.heard(report) > kSilence) faults_ += axes_.centre(report);
  }
  rate_ = mapping_.gain * mapping_.deflection(axes_.counts());
  const bool pressed = axes_.buttons() & ~held_;
  held_ &= axes_.buttons();
  return {pose_, pressed || lost_, nullptr, lost_, axes_.counts()};
}

const Driver kSpaceMouseDriver = {
    .name = "SpaceMouse",
    .recognises =
        [](const HidInfo& info) {
          const bool multi_axis = info.usage_page == 1 && info.usage == 8;
          const bool unknown = info.usage_page == 0;
          return multi_axis || (unknown && space_mouse_layout(info.vendor, info.product)) ||
                 describes(parse_report_descriptor(info.descriptor), kMultiAxis);
        },
    .never = [](const HidInfo& info) noexcept -> const char* {
      return never_a_space_mouse(info.vendor, info.product)
                 ? "a mouse, keyboard or receiver of a maker of SpaceMice"
                 : nullptr;
    },
    .check = [](const HidInfo& info) { space_mouse_axes(info); },
    .make = [](HidTransport& transport, const DriverSettings& s) -> std::unique_ptr<HidDevice> {
      return std::make_unique<SpaceMouse>(transport, s.range.speed, s.range.tilt_rate, s.start);
    },
    .force = nullptr,
    .fake_name = "fake:spacemouse",
    .fake = []() -> std::unique_ptr<FakeTransport> {
      return std::make_unique<FakeFirmware>(FakeModel::space_mouse_split);
    }};

}  // namespace ferrule
