// The force sensor at the holder: what a machine, or a person at the haptic device, gets to know of
// the holder's wrench.
//
//   s' = s + (1 - exp(-2 pi f_b T)) (F - s)      low pass of first order with bandwidth f_b
//   reading = R round((C s' + b + n)/R)          gains and cross-talk C, bias b, noise n, resolution
//
// per component, T the time since the reading before, t that since the first. C is the unit matrix
// with an error on its diagonal (gain) and beside it (cross-talk), drawn once per trial;
//   b = b_0 + walk(t) + k theta t + v(t)
// with b_0 drawn once per trial, a random walk whose deviation after t is bias_walk sqrt(t), a
// drift with temperature (k of each component and the rate theta of warming drawn per trial), and a
// vibration of one frequency with a phase per component. n is drawn for each reading,
// independently: `noise` is what a reader at 1 kHz sees. All are normally distributed. The first
// reading, at rest, is that of a sensor just tared: without b, and without noise since a tare takes
// the mean of many. A moment is measured as a force at `arm`, with the same errors.
#pragma once

#include <limits>

#include "sim/base/random.hpp"
#include "sim/model/state.hpp"

namespace ferrule {

struct ForceSensorModel {
  double noise = 0;                                            // standard deviation of n [N], >= 0
  double bias = 0;                                             // standard deviation of b [N], >= 0
  double bandwidth = std::numeric_limits<double>::infinity();  // f_b [Hz], > 0
  double resolution = 0;                                       // R [N], >= 0; 0: as fine as it is
  double arm = 0.01;                                           // [m], > 0
  // Standard deviations, all >= 0.
  double bias_walk = 0;             // [N/sqrt(s)]
  double gain_error = 0;            // [-]
  double cross_talk = 0;            // of every other component [-]
  double drift = 0;                 // k [N/K]
  double temperature_rate = 0;      // theta [K/s]
  double vibration = 0;             // of v [N]
  double vibration_frequency = 50;  // [Hz], > 0
  // Of who reads it (insertion/sensed_wrench.hpp).
  double tare_time = 0;  // of the mean that is the tare in free air [s], >= 0; 0: the first reading
  double dead_band = 0;  // below which a force relative to the tare counts as none [N], >= 0
  // Of who looks for the bore (no part of a reading): where it takes its entrance to be, along x,
  // and the standard deviation of that [m]. What counts as inserted does not depend on it.
  double entrance_error = 0;
  double entrance_sd = 0;  // >= 0

  bool ideal() const noexcept {
    return noise == 0 && resolution == 0 && gain_error == 0 && cross_talk == 0 && !biased() &&
           bandwidth == std::numeric_limits<double>::infinity();
  }
  // Does b change from trial to trial, or in one?
  bool biased() const noexcept {
    return bias > 0 || bias_walk > 0 || drift * temperature_rate > 0 || vibration > 0;
  }
  // Standard deviation of a reading of a force of size `force` [N] after `time` [s].
  double deviation(double force, double time) const noexcept;
};

class ForceSensor {
 public:
  ForceSensor() noexcept : ForceSensor({}, 0, 0) {}  // ideal
  // Its chance is that of (seed, trial).
  ForceSensor(const ForceSensorModel& model, std::uint64_t seed, std::uint64_t trial) noexcept;

  // The reading [N, N m] for the wrench `holder` at a time `period` [s] after the one before. An
  // ideal sensor returns `holder` bit for bit.
  Wrench read(const Wrench& holder, double period) noexcept;

 private:
  double normal() noexcept;  // a standard one, of 24 bits
  Wrench normals() noexcept;
  Wrench bias_after(double period) noexcept;

  ForceSensorModel model_;
  RandomWords random_;
  Matrix5 gain_ = Matrix5::Identity();  // C
  Wrench smooth_ = Wrench::Zero();
  Wrench bias_ = Wrench::Zero();                                   // b_0 + walk
  Wrench warming_ = Wrench::Zero();                                // k theta [N/s]
  Wrench swing_ = Wrench::Zero(), swing_across_ = Wrench::Zero();  // v, and a quarter period later
  double period_ = 0, followed_ = 0;  // of the last reading: T, and 1 - exp(-2 pi f_b T)
  double time_ = 0;
  bool tared_ = false;
};

}  // namespace ferrule
