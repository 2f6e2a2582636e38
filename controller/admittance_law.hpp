// Three admittance laws, each nested in the next: the gains of one are the first gains of the next,
// and the further gains have values at which they change nothing.
//
//   linear     v = v_0 + A f                                              6 gains
//   phased     v = (1 - p) (v_0 + A f) + p (v_1 + B f)                   13 gains
//              p = 1 - exp(-d / L): 0 outside the bore, towards 1 inside
//              linear where v_1 = v_0 and B = A, for any L
//   saturated  phased with g(f) in place of f                            15 gains
//              g(f) = sign(f) h / (1 + s h),  h = max(0, |f| - f_0)
//              phased where f_0 = 0 and s = 0
//
// axis by axis, in the hand's world: f is the observed force relative to that at rest [N], d the
// depth of the hand past the entrance [m], >= 0. No answer to a force below the dead band f_0 [N];
// the answer to a large one tends to that to 1/s [N]. The lead-in cone is outside by this depth.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>

#include "controller/gain.hpp"
#include "controller/observation.hpp"
#include "sim/base/elementary.hpp"

namespace ferrule {

inline constexpr int kLinearGains = 6, kPhasedGains = 13, kSaturatedGains = 15;
inline constexpr std::array<Gain, kSaturatedGains> kAdmittanceGains = {{
    {"speed_x", "v_0x", "m/s"},
    {"speed_y", "v_0y", "m/s"},
    {"speed_z", "v_0z", "m/s"},
    {"yield_x", "A_x", "m/(s N)"},
    {"yield_y", "A_y", "m/(s N)"},
    {"yield_z", "A_z", "m/(s N)"},
    {"phase_length", "L", "m", Gain::positive},
    {"bore_speed_x", "v_1x", "m/s"},
    {"bore_speed_y", "v_1y", "m/s"},
    {"bore_speed_z", "v_1z", "m/s"},
    {"bore_yield_x", "B_x", "m/(s N)"},
    {"bore_yield_y", "B_y", "m/(s N)"},
    {"bore_yield_z", "B_z", "m/(s N)"},
    {"dead_band", "f_0", "N", Gain::not_negative},
    {"saturation", "s", "1/N", Gain::not_negative},
}};

// g(f) [N] of a force [N], a dead band [N] and a saturation [1/N].
template <class T>
T saturated_force(double force, const T& dead_band, const T& saturation) {
  const T beyond = std::abs(force) - dead_band;
  if (beyond <= 0.0) return T(0.0);
  const T size = beyond / (1.0 + saturation * beyond);
  return force < 0 ? T(-size) : size;
}

// Velocity [m/s] from the first `gains` (6, 13 or 15) of the table. T is double, or a dual number
// when fitting.
template <class T>
Eigen::Matrix<T, 3, 1> admittance_velocity(const T* gain, int gains,
                                           const Observation& observation) {
  Eigen::Matrix<T, 3, 1> velocity;
  for (int i = 0; i < 3; ++i) {
    const double force = observation.wrench[i];
    const T f = gains < kSaturatedGains ? T(force) : saturated_force(force, gain[13], gain[14]);
    velocity[i] = gain[i] + gain[3 + i] * f;
    if (gains < kPhasedGains) continue;
    const T outside = elementary::exp(-observation.depth / gain[6]);
    velocity[i] = outside * velocity[i] + (1.0 - outside) * (gain[7 + i] + gain[10 + i] * f);
  }
  return velocity;
}

}  // namespace ferrule
