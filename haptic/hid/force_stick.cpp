#include "haptic/hid/force_stick.hpp"

#include <algorithm>
#include <cmath>

#include "haptic/hid/fake_firmware.hpp"

namespace ferrule {

AxisReader force_stick_axes(const HidInfo& info) {
  AxisReader axes(parse_report_descriptor(info.descriptor));
  const auto& places = axes.places();
  if (std::none_of(places.begin(), places.begin() + 3, [](const AxisPlace& p) { return p.there; }))
    throw DeviceTrouble(info.path + ": its report descriptor names no axis X, Y or Z");
  return axes;
}

Mapping force_stick_mapping(const AxisReader& axes, double reach) noexcept {
  Mapping m;
  m.kind = Mapping::Kind::position;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!axes.places()[axis].there) continue;
    m.centre[axis] = axes.places()[axis].centre;
    m.limit[axis] = axes.places()[axis].limit;
  }
  m.gain(0, 0) = reach;
  m.gain(1, 1) = -reach;
  m.gain(2, 2) = reach;
  return m;
}

double force_stick_step(const HidInfo& info, double reach) {
  const AxisReader axes = force_stick_axes(info);
  const Eigen::Vector3d motors = force_stick_motors(info);
  double step = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (axes.places()[axis].there && motors[static_cast<Eigen::Index>(axis)] > 0)
      step = std::max(step, reach / axes.places()[axis].limit);
  return step;
}

Eigen::Vector3d force_stick_motors(const HidInfo& info) {
  const PidReports reports(parse_report_descriptor(info.descriptor));
  return {1, reports.axes() > 1 ? 1.0 : 0.0, 0};
}

ForceStick::ForceStick(HidTransport& transport, double reach, double full_force,
                       const HandPose& start)
    : transport_(transport),
      axes_(force_stick_axes(transport.info())),
      mapping_(force_stick_mapping(axes_, reach)),
      output_(transport),
      start_(start),
      full_force_(full_force) {
  lost_ = !axes_.poll(transport_, 0);
  held_ = axes_.buttons();
  reports_ = axes_.reports();
  repeats_ = axes_.repeats();
}

HandSample ForceStick::read(double t) {
  time_ = t;
  lost_ = lost_ || !axes_.poll(transport_, t);
  learn_rhythm(t);
  find_origin();
  HandPose pose = start_;
  if (origin_) pose += mapping_.gain * (mapping_.deflection(axes_.counts()) - *origin_);
  const bool pressed = axes_.buttons() & ~held_;
  held_ &= axes_.buttons();
  const double silence = t - heard_;
  const double age = steady_ && silence > kSilence ? silence : 0;
  return {pose, pressed || lost_, nullptr, lost_, axes_.counts(), age};
}

void ForceStick::render(const HandWrench& wrench) {
  for (Eigen::Index axis = 0; axis < 2; ++axis) {
    const double sign = std::copysign(1.0, mapping_.gain(axis, axis));
    const double part = sign * wrench[axis] / full_force_;
    force_[static_cast<std::size_t>(axis)] =
        std::isfinite(part) ? std::clamp(part, -1.0, 1.0) : 0.0;
  }
  // The device's effects end in its own time, of which a loop that misses deadlines has seen less.
  const double passed = std::chrono::duration<double>(Clock::now() - made_).count();
  if (!output_.update(std::max(time_, passed), force_)) lost_ = true;
}

void ForceStick::learn_rhythm(double t) noexcept {
  if (axes_.reports() == reports_) return;
  if (t - heard_ > kSteadyGap) {  // it paused: another second
    since_ = t;
    repeats_ = axes_.repeats();
  }
  reports_ = axes_.reports();
  heard_ = t;
  if (t - since_ < kLearning) return;
  steady_ = steady_ || axes_.repeats() - repeats_ >= kRepeats;
  since_ = t;
  repeats_ = axes_.repeats();
}

// Many sticks report only when they move: until then the hand is where the scene starts.
void ForceStick::find_origin() noexcept {
  for (const AxisPlace& place : axes_.places())
    if (!origin_ && place.there && axes_.heard(place.field.report) >= 0) {
      origin_ = mapping_.deflection(axes_.counts());
      held_ = axes_.buttons();
    }
}

namespace {

constexpr ForceDriver kForce = {ForceStick::kReportPeriod, force_stick_motors, force_stick_step};

}  // namespace

const Driver kForceStickDriver = {
    .name = "force stick",
    .recognises =
        [](const HidInfo& info) {
          return PidReports::in(parse_report_descriptor(info.descriptor));
        },
    .never = [](const HidInfo&) noexcept -> const char* { return nullptr; },
    .check =
        [](const HidInfo& info) {
          force_stick_axes(info);
          force_stick_motors(info);
        },
    .make = [](HidTransport& transport, const DriverSettings& s) -> std::unique_ptr<HidDevice> {
      return std::make_unique<ForceStick>(transport, s.range.reach, s.full_force, s.start);
    },
    .force = &kForce,
    .fake_name = "fake:pid",
    .fake = []() -> std::unique_ptr<FakeTransport> {
      return std::make_unique<FakeFirmware>(FakeModel::pid_22);
    }};

}  // namespace ferrule
