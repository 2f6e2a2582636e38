#include "sim/scene/force_sensor.hpp"

#include <boost/random/normal_distribution.hpp>
#include <cmath>

#include "sim/base/elementary.hpp"

namespace ferrule {
namespace {

// The multiple of `step` nearest to x; std::round is a call into a library.
double rounded_to(double step, double x) noexcept {
  constexpr double kWhole = 0x1p51;  // beyond it all doubles are
  const double steps = x / step;
  if (!(std::abs(steps) < kWhole)) return x;
  return step * static_cast<double>(static_cast<std::int64_t>(steps + std::copysign(0.5, steps)));
}

}  // namespace

double ForceSensorModel::deviation(double force, double time) const noexcept {
  double variance = 0;
  for (const double d : {noise, bias, bias_walk * std::sqrt(time), drift * temperature_rate * time,
                         vibration, gain_error * force, 2 * cross_talk * force})  // of four others
    variance += d * d;
  return std::sqrt(variance);
}

ForceSensor::ForceSensor(const ForceSensorModel& model, std::uint64_t seed,
                         std::uint64_t trial) noexcept
    : model_(model), random_({seed, trial, Draw::sensor}) {
  if (model_.bias > 0) bias_ = model_.bias * normals();
  if (model_.gain_error > 0) gain_.diagonal() += model_.gain_error * normals();
  if (model_.cross_talk > 0)
    for (int i = 0; i < 5; ++i)
      for (int j = 0; j < 5; ++j)
        if (i != j) gain_(i, j) = model_.cross_talk * normal();
  if (model_.drift * model_.temperature_rate > 0) {
    const double rate = model_.temperature_rate * normal();
    warming_ = model_.drift * rate * normals();
  }
  if (model_.vibration > 0)
    for (int i = 0; i < 5; ++i) {
      const double a = normal(), b = normal();
      const double amplitude = std::numbers::sqrt2 * model_.vibration / std::sqrt(a * a + b * b);
      swing_[i] = amplitude * a;
      swing_across_[i] = amplitude * b;
    }
}

// By a ziggurat (Marsaglia and Tsang, 2000), which takes no logarithm.
double ForceSensor::normal() noexcept {
  return boost::random::normal_distribution<float>()(random_);
}

Wrench ForceSensor::normals() noexcept {
  Wrench all;
  for (double& each : all) each = normal();
  return all;
}

Wrench ForceSensor::bias_after(double period) noexcept {
  time_ += period;
  if (model_.bias_walk > 0) bias_ += model_.bias_walk * std::sqrt(period) * normals();
  Wrench all = bias_;
  if (model_.drift * model_.temperature_rate > 0) all += time_ * warming_;
  if (model_.vibration > 0) {
    // Turned by 2 pi f T.
    const double turns = model_.vibration_frequency * period;
    const double angle = 2 * std::numbers::pi * (turns - std::round(turns));
    const double c = elementary::cos(angle), s = elementary::sin(angle);
    const Wrench swing = c * swing_ - s * swing_across_;
    swing_across_ = s * swing_ + c * swing_across_;
    swing_ = swing;
    all += swing_;
  }
  return all;
}

Wrench ForceSensor::read(const Wrench& holder, double period) noexcept {
  if (model_.ideal()) return holder;
  if (period != period_)
    followed_ = -elementary::expm1(-2 * std::numbers::pi * model_.bandwidth * period);
  period_ = period;
  for (int i = 0; i < 5; ++i) {
    const double force =
        i < 3 ? holder[i] : holder[i] / model_.arm;  // moments as forces at the arm
    smooth_[i] = tared_ ? smooth_[i] + followed_ * (force - smooth_[i]) : force;
  }
  Wrench reading = smooth_;
  if (model_.gain_error > 0 || model_.cross_talk > 0) reading = gain_ * smooth_;
  if (tared_) {
    reading += bias_after(period);
    if (model_.noise > 0)
      for (double& r : reading) r += model_.noise * normal();
  }
  tared_ = true;
  if (model_.resolution > 0)
    for (double& r : reading) r = rounded_to(model_.resolution, r);
  reading.tail<2>() *= model_.arm;
  return reading;
}

}  // namespace ferrule
