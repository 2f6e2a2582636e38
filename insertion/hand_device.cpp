#include "insertion/hand_device.hpp"

#include <algorithm>
#include <cmath>

#include "insertion/scene_scaling.hpp"
#include "sim/base/minimum_jerk.hpp"

namespace ferrule {
namespace {

constexpr double kTiltRate = 1e-3;           // [rad/s]; assumed
constexpr double kRest = 0.3, kAfter = 0.5;  // of the fake hand, before and after [s]
constexpr double kBriskness = 0.7;           // its peak speed, of the device's full speed
constexpr double kCorrection = 0.1;          // time constant of what it corrects by eye [s]

// Part of a minimum-jerk motion done at part q of its time, at rest before and after.
double travelled(double q) {
  return minimum_jerk(std::clamp(q, 0.0, 1.0));
}

class FakeHand : public Device {
 public:
  FakeHand(const Driver& driver, std::unique_ptr<FakeTransport> model, const Scene& scene,
           const State& start, double gain, double full_force)
      : model_(std::move(model)),
        device_(driver.make(*model_, driver_settings(scene, start, gain, full_force))),
        start_(scene_scaling(scene).motion_to_hand(start.command)),
        aligned_(start_),
        pose_(start_) {
    const Scaling scaling = scene_scaling(scene);
    const DeviceRange range = device_range(scene, gain);
    // In free flight the end follows the hand.
    aligned_.tail<4>() -= scaling.motion_to_hand(start.tip).tail<4>();
    const double way = scaling.motion * (start.tip[0] - scene.sensor.entrance_error +
                                         scene.success.depth + overshoot(scene));
    inserted_ = aligned_;
    inserted_[0] -= way;
    const double speed = kBriskness * scaling.motion * scene.limits.speed;
    const HandPose aside = (aligned_ - start_).cwiseAbs();
    aligning_ =
        kPeakOfMinimumJerk * std::max(aside.head<3>().maxCoeff() / speed,
                                      aside.tail<2>().maxCoeff() / (kBriskness * range.tilt_rate));
    pushing_ = kPeakOfMinimumJerk * way / speed;
  }

  HandSample read(double t) override {
    model_->deflect(counts(t));
    model_->press(t > kRest + aligning_ + pushing_ + kAfter ? 1 : 0);
    model_->advance(t);
    HandSample sample = device_->read(t);
    pose_ = sample.pose;
    return sample;
  }
  void render(const HandWrench& wrench) override { device_->render(wrench); }
  const Mapping* mapping() const noexcept override { return device_->mapping(); }

 private:
  HandPose meant(double t) const {
    const double a = travelled((t - kRest) / aligning_);
    const double p = travelled((t - kRest - aligning_) / pushing_);
    return start_ + a * (aligned_ - start_) + p * (inserted_ - aligned_);
  }

  // The deflection that the driver's mapping makes into the hand's motion.
  std::array<int, 6> counts(double t) const {
    const Mapping& m = *device_->mapping();
    const bool velocity = m.kind == Mapping::Kind::velocity;
    constexpr double kStep = 1e-3;  // [s]
    const HandPose wanted =
        velocity
            ? HandPose((meant(t + kStep) - meant(t)) / kStep + (meant(t) - pose_) / kCorrection)
            // A stick begins half its way back.
            : HandPose(meant(t) - 0.5 * (start_ + inserted_));
    std::array<int, 6> counts{};
    for (std::size_t axis = 0; axis < kRawAxes; ++axis) {
      const Eigen::Matrix<double, 5, 1> gain = m.gain.col(static_cast<Eigen::Index>(axis));
      if (gain.isZero() || !(m.limit[axis] > 0)) continue;
      const double d = std::clamp(gain.dot(wanted) / gain.squaredNorm(), -1.0, 1.0);
      const double dead = std::abs(d) * m.limit[axis] < 0.5 ? 0 : m.dead_zone;
      const double size = dead + std::abs(d) * (1 - m.dead_zone);
      counts[axis] =
          static_cast<int>(std::lround(m.centre[axis] + std::copysign(size, d) * m.limit[axis]));
    }
    return counts;
  }

  std::unique_ptr<FakeTransport> model_;
  std::unique_ptr<Device> device_;
  HandPose start_, aligned_, inserted_, pose_;
  double aligning_ = 0, pushing_ = 0;  // [s]
};

}  // namespace

DeviceRange device_range(const Scene& scene, double gain) noexcept {
  return {gain * scene_scaling(scene).motion * scene.limits.speed, gain * kTiltRate,
          gain * 0.5 * scene.scaling.hand_range};
}

DriverSettings driver_settings(const Scene& scene, const State& start, double gain,
                               double full_force) noexcept {
  return {device_range(scene, gain), full_force,
          scene_scaling(scene).motion_to_hand(start.command)};
}

std::unique_ptr<Device> fake_hand(const Driver& driver, std::unique_ptr<FakeTransport> model,
                                  const Scene& scene, const State& start, double gain,
                                  double full_force) {
  return std::make_unique<FakeHand>(driver, std::move(model), scene, start, gain, full_force);
}

}  // namespace ferrule
