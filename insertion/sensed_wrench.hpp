// What a hand gets to know of the wrench at the holder: read by a force sensor, scaled to the
// hand's world, and relative to a tare: the first reading, at rest before anything moves, so that
// the fibre's weight does not matter.
//
// Where the scene's sensor states tare_s, the tare follows what is read in free air, before the
// end reaches the ferrule and for the first tare_s in any case (a trial that begins within the
// lead-in begins where nothing touches): as a mean with that time constant. The relative wrench is none
// there, whatever the sensor's bias. Past it the tare holds. Where it states a dead band, a force
// relative to the tare counts by what it is more than that, in its direction; so does a moment, at
// the sensor's arm. Without either nothing changes.
#pragma once

#include <algorithm>
#include <limits>
#include <optional>

#include "haptic/scaling.hpp"
#include "sim/scene/scene.hpp"

namespace ferrule {

// How a scene's readings are tared.
struct Tare {
  double time = 0;                                               // tare_s [s]; 0: the first reading
  double dead_band = 0;                                          // at the tip's scale [N]
  double arm = 1;                                                // of a moment [m]
  double free_beyond = std::numeric_limits<double>::infinity();  // x of the holder's pose [m]
};
inline Tare scene_tare(const Scene& scene) noexcept {
  constexpr double margin = 2e-6;  // for a tilted end [m]; besides, for what registration misses
  return {scene.sensor.tare_time, scene.sensor.dead_band, scene.sensor.arm,
          scene.world.profile.lead_in_length - scene.world.holder.sag[0] + margin +
              scene.sensor.entrance_error + 3 * scene.sensor.entrance_sd};
}

class SensedWrench {
 public:
  // A reading every `period` [s].
  SensedWrench(const Scaling& scaling, const ForceSensor& sensor, double period,
               const Tare& tare = {}) noexcept
      : scaling_(scaling),
        sensor_(sensor),
        period_(period),
        tare_(tare),
        newest_(std::min(1.0, period / tare.time)) {}

  // Reads `holder`, of the fibre on the holder at the tip's scale [N, N m], with the holder at
  // `x` [m].
  void read(const Wrench& holder, double x) noexcept {
    const bool first = !at_rest_;
    absolute_ = scaling_.wrench_to_hand(sensor_.read(holder, period_));
    if (first) at_rest_ = absolute_;
    const bool begins = readings_++ * period_ < tare_.time;
    if (begins || (tare_.time > 0 && x > tare_.free_beyond)) {
      // A mean of all until there are enough for the time constant.
      if (!first) {
        ++free_;
        *at_rest_ += (free_ * newest_ < 1 ? 1.0 / free_ : newest_) * (absolute_ - *at_rest_);
      }
      relative_.setZero();
      return;
    }
    relative_ = absolute_ - *at_rest_;
    if (tare_.dead_band > 0) {
      const double band = scaling_.force * tare_.dead_band;
      leave_out(band, relative_.head<3>());
      leave_out(band * tare_.arm * scaling_.motion, relative_.tail<2>());
    }
  }

  // The last reading, in the hand's world [N, N m].
  const HandWrench& absolute() const noexcept { return absolute_; }
  const HandWrench& relative() const noexcept { return relative_; }

 private:
  template <class Vector>
  static void leave_out(double band, Vector&& v) noexcept {
    const double size = v.norm();
    v *= size > band ? (size - band) / size : 0;
  }

  Scaling scaling_;
  ForceSensor sensor_;
  double period_;
  Tare tare_;
  double newest_;  // its share in the tare
  std::optional<HandWrench> at_rest_;
  int readings_ = 0, free_ = 0;  // all, and those in free air after the first
  HandWrench absolute_ = HandWrench::Zero(), relative_ = HandWrench::Zero();
};

}  // namespace ferrule
