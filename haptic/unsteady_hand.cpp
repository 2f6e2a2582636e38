#include "haptic/unsteady_hand.hpp"

#include <numbers>

#include "sim/base/elementary.hpp"

namespace ferrule {
namespace {

constexpr double kHesitationFade = 0.1;  // time constant of the drive [s]
constexpr double kTau = 2 * std::numbers::pi;

}  // namespace

UnsteadyHand::UnsteadyHand(double tremor, double hesitation_rate, double period,
                           std::function<double()> uniform)
    : amplitude_(tremor),
      hesitation_rate_(hesitation_rate),
      period_(period),
      uniform_(std::move(uniform)) {
  for (auto& axis : tremor_)
    for (auto& s : axis) s = {8 + 4 * uniform_(), kTau * uniform_()};
}

double UnsteadyHand::drive(double t) {
  if (uniform_() < hesitation_rate_ * period_ && t > pause_until_)
    pause_until_ = t + 0.2 + 0.6 * uniform_();
  const double wanted = t < pause_until_ ? 0.0 : 1.0;
  drive_ += (wanted - drive_) * period_ / kHesitationFade;
  return drive_;
}

Eigen::Vector3d UnsteadyHand::tremor_velocity(double t) const noexcept {
  Eigen::Vector3d velocity;
  for (int axis = 0; axis < 3; ++axis) {
    velocity[axis] = 0;
    for (const auto& [frequency, phase] : tremor_[static_cast<std::size_t>(axis)])
      velocity[axis] += amplitude_ / std::numbers::sqrt2 * kTau * frequency *
                        elementary::cos(kTau * frequency * t + phase);
  }
  return velocity;
}

}  // namespace ferrule
