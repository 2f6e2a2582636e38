// How a holder answers what it is told, measured on its way in free air at one speed: by how much it
// is late, and by how much more than that it moves.
//
// At a time T after it was told to move at the speed v it has moved by g v (T - d) along its way and
// moves at g v, its mean over at least the last half of T: a supervisor lets it go by fits and starts
// where the sensor is noisy. d is a delay or the time constant of a lag.
#pragma once

#include <array>

namespace ferrule {

class HandResponse {
 public:
  // Nothing is left to measure where the delay is known [s]; 0: it is not.
  explicit HandResponse(double delay = 0) noexcept : delay_(delay), measured_(delay > 0) {}

  // It has moved that far [m], `time` after it set out at `speed` [s, m/s].
  void moved(double way, double time, double speed) noexcept;

  bool measured() const noexcept { return measured_; }
  double delay() const noexcept { return delay_; }  // d, the best guess until then [s]
  double gain() const noexcept { return gain_; }    // g [-], between 1/2 and 2; 1 until then

 private:
  struct Mark {
    double time, way;  // [s, m]
  };
  double delay_, gain_ = 1;
  bool measured_;
  std::array<Mark, 2> marks_{};
};

}  // namespace ferrule
