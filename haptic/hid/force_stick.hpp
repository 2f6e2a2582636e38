// A force-feedback stick or wheel (USB class PID): its position is the hand's position, and it
// pushes back along one or two axes.
//
// X moves the hand along x, Y along -y (a stick's Y grows towards the operator; pull for up), Z
// along z; tilts stay as they are. The hand starts where the scene starts, wherever the stick is.
// Forces along x and y are felt at X and Y; a device with one axis shows the force along x alone.
//
// Many sticks report only when they move, so that silence is not a fault. One that also repeats itself
// is known by that: a second without a gap above kSteadyGap, with kRepeats reports that were the
// same as the one before, and from then on a silence longer than kSilence is the sample's age.
#pragma once

#include <chrono>

#include "haptic/hid/driver.hpp"
#include "haptic/hid/force_output.hpp"

namespace ferrule {

// Its axes, of which it has X, Y or Z. Throws DeviceTrouble where it has none of them, and the hand
// would never move.
AxisReader force_stick_axes(const HidInfo& info);

// Full deflection is `reach` [m] to either side.
Mapping force_stick_mapping(const AxisReader& axes, double reach) noexcept;

// The coarsest step of its position along an axis with a motor, where full deflection is `reach`
// [m]; 0 where none of these is an axis. Throws DeviceTrouble.
double force_stick_step(const HidInfo& info, double reach);

// Along which of x y z such a device has a motor: 1, or 0. Throws DeviceTrouble.
Eigen::Vector3d force_stick_motors(const HidInfo& info);

class ForceStick : public HidDevice {
 public:
  // Longest time between reports of a stick that moves [s]; USB sticks are read every 8 to 10 ms.
  static constexpr double kReportPeriod = 0.016;
  static constexpr double kLearning = 1, kSteadyGap = 0.025, kSilence = 0.1;  // [s]
  static constexpr int kRepeats = 10;

  // `full_force` [N] at the hand is what the device does at most; what is beyond is cut.
  // `transport` must outlive this. Throws DeviceTrouble (force_stick_axes,
  // haptic/hid/force_output.hpp).
  ForceStick(HidTransport& transport, double reach, double full_force, const HandPose& start);

  HandSample read(double t) override;
  void render(const HandWrench& wrench) override;
  const Mapping* mapping() const noexcept override { return &mapping_; }

  const AxisReader& axes() const noexcept override { return axes_; }
  std::array<double, 2> force() const noexcept override { return force_; }

 private:
  using Clock = std::chrono::steady_clock;

  void find_origin() noexcept;
  void learn_rhythm(double t) noexcept;

  HidTransport& transport_;
  AxisReader axes_;
  Mapping mapping_;
  ForceOutput output_;
  HandPose start_;
  double full_force_, time_ = 0;
  Clock::time_point made_ = Clock::now();
  std::optional<Eigen::Matrix<double, kRawAxes, 1>> origin_;  // deflection at the start
  std::array<double, 2> force_{};
  std::uint32_t held_ = 0;
  bool lost_ = false;
  bool steady_ = false;           // reports all the time, moved or not
  double heard_ = 0, since_ = 0;  // last report, and begin of the second that is looked at [s]
  std::int64_t reports_ = 0, repeats_ = 0;  // until `heard_`, until `since_`
};

// What has a constant force (haptic/hid/pid_reports.hpp).
extern const Driver kForceStickDriver;

}  // namespace ferrule
