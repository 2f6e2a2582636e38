#include "sim/scene/force_sensor.hpp"

#include <cmath>

#include "sim/elementary.hpp"

namespace ferrule {

ForceSensor::ForceSensor(const ForceSensorModel& model, std::uint64_t seed,
                         std::uint64_t trial) noexcept
    : model_(model), random_(seed, trial, Draw::sensor) {
  if (model_.bias > 0)
    for (double& b : bias_) b = model_.bias * random_.normal();
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
  if (tared_) {
    reading += bias_;
    if (model_.noise > 0)
      for (double& r : reading) r += model_.noise * random_.normal();
  }
  tared_ = true;
  if (model_.resolution > 0)
    for (double& r : reading) r = model_.resolution * std::round(r / model_.resolution);
  reading.tail<2>() *= model_.arm;
  return reading;
}

}  // namespace ferrule
