// The motion of a hand from one place to another (Flash and Hogan 1985): of all with rest at both
// ends the one with the least jerk.
#pragma once

namespace ferrule {

// Part of the way done at part p of the time, 0 <= p <= 1.
constexpr double minimum_jerk(double p) noexcept {
  return p * p * p * (10 + p * (-15 + 6 * p));
}

// Its peak speed over the mean one.
inline constexpr double kPeakOfMinimumJerk = 1.875;

}  // namespace ferrule
