// The force sensor at the holder: what a machine, or a person at the haptic device, gets to know of
// the holder's wrench.
//
//   s' = s + (1 - exp(-2 pi f_b T)) (F - s)      low pass of first order with bandwidth f_b
//   reading = R round((s' + b + n)/R)            bias b, noise n, resolution R
//
// per component, T the time since the reading before. b is drawn once per trial from a normal
// distribution, n for each reading, independently: `noise` is what a reader at 1 kHz sees. The
// first reading, at rest, is that of a sensor just tared: without bias, and without noise since a
// tare takes the mean of many. A moment is measured as a force at `arm`, with the same errors.
#pragma once

#include <limits>

#include "sim/scene/random.hpp"
#include "sim/state.hpp"

namespace ferrule {

struct ForceSensorModel {
  double noise = 0;                                            // standard deviation of n [N], >= 0
  double bias = 0;                                             // standard deviation of b [N], >= 0
  double bandwidth = std::numeric_limits<double>::infinity();  // f_b [Hz], > 0
  double resolution = 0;                                       // R [N], >= 0; 0: as fine as it is
  double arm = 0.01;                                           // [m], > 0

  bool ideal() const noexcept {
    return noise == 0 && bias == 0 && resolution == 0 &&
           bandwidth == std::numeric_limits<double>::infinity();
  }
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
  ForceSensorModel model_;
  RandomStream random_;
  Wrench smooth_ = Wrench::Zero(), bias_ = Wrench::Zero();
  bool tared_ = false;
};

}  // namespace ferrule
