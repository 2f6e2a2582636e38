#include "sim/scene/force_sensor.hpp"

#include <boost/random/normal_distribution.hpp>
#include <cmath>

#include "sim/base/elementary.hpp"

namespace ferrule {
double ForceSensorModel::deviation(double force, double time) const noexcept {
  double d = std::hypot(noise, bias);
  for (const double more : {bias_walk * std::sqrt(time), drift * temperature_rate * time, vibration,
                            gain_error * force, 2 * cross_talk * force})  // of four others
    if (more > 0) d = std::hypot(d, more);
  return d;
}

ForceSensor::ForceSensor(const ForceSensorModel& model, std::uint64_t seed,
                         std::uint64_t trial) noexcept
    : model_(model), random_(seed, trial, Draw::sensor) {
  if (model_.bias > 0) bias_ = model_.bias * normals();
  if (model_.gain_error > 0) gain_.diagonal() += model_.gain_error * normals();
  if (model_.cross_talk > 0)
    for (int i = 0; i < 5; ++i)
      for (int j = 0; j < 5; ++j)
        if (i != j) gain_(i, j) = model_.cross_talk * random_.normal();
  if (model_.drift * model_.temperature_rate > 0) {
    const double rate = model_.temperature_rate * random_.normal();
    warming_ = model_.drift * rate * normals();
  }
  if (model_.vibration > 0)
    for (int i = 0; i < 5; ++i) {
      const double a = random_.normal(), b = random_.normal();
      const double amplitude = std::numbers::sqrt2 * model_.vibration / std::sqrt(a * a + b * b);
      swing_[i] = amplitude * a;
      swing_across_[i] = amplitude * b;
    }
}

// By a ziggurat (Marsaglia and Tsang, 2000), which takes no logarithm.
Wrench ForceSensor::normals() noexcept {
  boost::random::normal_distribution<double> normal;
  return Wrench::NullaryExpr([&] { return normal(random_); });
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
  Wrench force = holder;  // moments as forces at the arm
  force.tail<2>() /= model_.arm;
  if (!tared_) {
    smooth_ = force;
  } else {
    smooth_ -=
        elementary::expm1(-2 * std::numbers::pi * model_.bandwidth * period) * (force - smooth_);
  }
  Wrench reading = smooth_;
  if (model_.gain_error > 0 || model_.cross_talk > 0) reading = gain_ * smooth_;
  if (tared_) {
    reading += bias_after(period);
    if (model_.noise > 0) reading += model_.noise * normals();
  }
  tared_ = true;
  if (model_.resolution > 0)
    for (double& r : reading) r = model_.resolution * std::round(r / model_.resolution);
  reading.tail<2>() *= model_.arm;
  return reading;
}

}  // namespace ferrule
