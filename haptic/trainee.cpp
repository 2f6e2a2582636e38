#include "haptic/trainee.hpp"

#include <algorithm>
#include <cmath>

#include "sim/base/minimum_jerk.hpp"

namespace ferrule {
namespace {

constexpr double kRest = 0.3;        // the hand rests before it starts [s]
constexpr double kAfterwards = 0.5;  // and after it has arrived [s]
constexpr double kPressFrom = 0.7;   // phase at which it begins to press: well inside by then

// The phase at which part of the way is made.
double phase_at(double part) noexcept {
  double low = 0, high = 1;
  for (int i = 0; i < 50; ++i) {
    const double middle = (low + high) / 2;
    (minimum_jerk(middle) < part ? low : high) = middle;
  }
  return high;
}

}  // namespace

TraineeTraits trainee_traits(double skill) noexcept {
  const auto from_to = [&](double at_0, double at_1) { return at_0 + (at_1 - at_0) * skill; };
  return {.delay = from_to(0.25, 0.15),
          .peak_speed = from_to(0.7, 1.0),
          .yield = from_to(0.5e-3, 1.0e-3),
          .slowing_force = from_to(1.5, 3.0),
          .tremor = from_to(8e-6, 1e-6),
          .hesitation_rate = from_to(0.3, 0.02)};
}

Trainee::Trainee(const TraineeTraits& traits, const TraineeTask& task,
                 std::function<double()> uniform)
    : traits_(traits),
      task_(task),
      hand_(traits.tremor, traits.hesitation_rate, task.period, std::move(uniform)),
      pose_(task.start) {
  const auto delayed = static_cast<std::size_t>(std::lround(traits_.delay / task_.period));
  felt_.assign(std::max<std::size_t>(1, delayed), HandWrench::Zero());
}

HandSample Trainee::read(double t) {
  pose_ += velocity_ * (t - time_);
  time_ = t;
  return {pose_, finished_at_ >= 0 && t >= finished_at_ + kAfterwards};
}

void Trainee::render(const HandWrench& wrench) {
  const HandWrench felt = felt_[next_];  // the oldest in the ring
  felt_[next_] = wrench;
  next_ = (next_ + 1) % felt_.size();

  velocity_.setZero();
  if (time_ < kRest) return;
  const double force = felt.head<3>().norm();
  advance_intention(force);
  velocity_[0] = -speed_;
  velocity_.segment<2>(1) = yield(force) * felt.segment<2>(1);
  velocity_[1] -=
      yield(force) * task_.press * std::max(0.0, (phase_ - kPressFrom) / (1 - kPressFrom));
  velocity_.tail<2>() = traits_.tilt_yield * felt.tail<2>();
  velocity_.segment<2>(1) += steering();
  velocity_.head<3>() += hand_.tremor_velocity(time_);
}

HandTwist Trainee::answer(double t, const HandPose& pose, const HandWrench& wrench) {
  time_ = t;
  pose_ = pose;
  phase_ = phase_at((task_.start[0] - pose[0]) / task_.distance);
  render(wrench);
  return velocity_;
}

void Trainee::advance_intention(double force) noexcept {
  const double drive = hand_.drive(time_);
  // A minimum-jerk motion peaks at 15/8 of its mean speed.
  const double duration = kPeakOfMinimumJerk * task_.distance / (traits_.peak_speed * task_.speed);
  const double slowed = force / traits_.slowing_force;
  const double rate = drive / (duration * (1 + slowed * slowed));
  const double p = std::min(1.0, phase_ + rate * task_.period);
  speed_ = task_.distance * (minimum_jerk(p) - minimum_jerk(phase_)) / task_.period;
  phase_ = p;
  if (phase_ >= 1 && finished_at_ < 0) finished_at_ = time_;
}

// Under a force of this size, where the hand is [m/s per N].
double Trainee::yield(double force) const noexcept {
  const bool inside = task_.start[0] - pose_[0] > task_.entrance;
  const double u = force * force / (traits_.slowing_force * traits_.slowing_force);
  return traits_.yield * (inside ? traits_.bore_yield : 1) *
         (1 + (traits_.force_yield - 1) * u / (1 + u)) * (1 + (traits_.late_yield - 1) * phase_);
}

// Of the period to come, by the way that the intention makes in it.
Eigen::Vector2d Trainee::steering() const noexcept {
  if (!task_.aim) return Eigen::Vector2d::Zero();
  const double now = (task_.start[0] - pose_[0]) / task_.aim->within;
  const double next = now + speed_ * task_.period / task_.aim->within;
  if (!(now >= 0 && now < 1)) return Eigen::Vector2d::Zero();
  const double made = minimum_jerk(now), more = minimum_jerk(std::min(1.0, next)) - made;
  const Eigen::Vector2d left = task_.aim->lateral - pose_.segment<2>(1);
  return std::min(1.0, more / (1 - made)) / task_.period * left;
}

}  // namespace ferrule
