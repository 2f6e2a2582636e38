// What a hand gets to know of the wrench at the holder: read by a force sensor, scaled to the
// hand's world, and relative to the first reading, at rest before anything moves, so that the
// fibre's weight does not matter.
#pragma once

#include <optional>

#include "haptic/scaling.hpp"
#include "sim/scene/force_sensor.hpp"

namespace ferrule {

class SensedWrench {
 public:
  // A reading every `period` [s].
  SensedWrench(const Scaling& scaling, const ForceSensor& sensor, double period) noexcept
      : scaling_(scaling), sensor_(sensor), period_(period) {}

  // Reads `holder`, of the fibre on the holder at the tip's scale [N, N m].
  void read(const Wrench& holder) noexcept {
    absolute_ = scaling_.wrench_to_hand(sensor_.read(holder, period_));
    if (!at_rest_) at_rest_ = absolute_;
    relative_ = absolute_ - *at_rest_;
  }

  // The last reading, in the hand's world [N, N m].
  const HandWrench& absolute() const noexcept { return absolute_; }
  const HandWrench& relative() const noexcept { return relative_; }

 private:
  Scaling scaling_;
  ForceSensor sensor_;
  double period_;
  std::optional<HandWrench> at_rest_;
  HandWrench absolute_ = HandWrench::Zero(), relative_ = HandWrench::Zero();
};

}  // namespace ferrule
