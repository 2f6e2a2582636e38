// The parametric insertion law: an intended motion along -x and an admittance.
//
//   v_x = -v_c r(t) (1 - exp((d - d_e) / L)) / (1 + k |f|^2) + A_x f_x,  r = (s (2 - s))^2,
//                                                                        s = min(1, t / t_r)
//   v_y = A_y f_y + b_y + c_y d
//   v_z = A_z f_z + b_z + c_z d
//
// in the hand's world, with f the observed force relative to that at rest [N], d the depth of the
// hand past the entrance [m] and t the time since the start [s]. It speeds up after the start as a
// minimum-jerk motion does (to its full speed at t_r), slows down towards the end depth d_e and
// under force, and yields to force; b and c let it lean to one side, more so deeper inside
// (operators press the fibre lightly onto the bore). With k = 0 and far from both ends it is the
// linear admittance law.
//
// The guarded law, of two more gains, has two phases: past the entrance, d > 0, it yields by B_y and
// B_z in place of A_y and A_z.
#pragma once

#include <Eigen/Core>
#include <array>

#include "controller/controller.hpp"
#include "controller/gain.hpp"
#include "sim/base/elementary.hpp"

namespace ferrule {

inline constexpr int kGains = 12, kGuardedGains = 14;
inline constexpr std::array<Gain, kGuardedGains> kGainTable = {{
    {"cruise_speed", "v_c", "m/s"},
    {"ramp_time", "t_r", "s", Gain::positive},
    {"end_depth", "d_e", "m"},
    {"end_length", "L", "m", Gain::positive},
    {"slowing", "k", "1/N^2"},
    {"yield_x", "A_x", "m/(s N)"},
    {"yield_y", "A_y", "m/(s N)"},
    {"yield_z", "A_z", "m/(s N)"},
    {"drift_y", "b_y", "m/s"},
    {"drift_z", "b_z", "m/s"},
    {"lean_y", "c_y", "1/s"},
    {"lean_z", "c_z", "1/s"},
    {"bore_yield_y", "B_y", "m/(s N)"},
    {"bore_yield_z", "B_z", "m/(s N)"},
}};

// Velocity [m/s] from the first `gains` (12 or 14) of the table. T is double, or a dual number when
// fitting.
template <class T>
Eigen::Matrix<T, 3, 1> insertion_velocity(const T* gain, int gains,
                                          const Observation& observation) {
  const Eigen::Vector3d force = observation.wrench.head<3>();
  const double depth = observation.depth;
  T since = observation.time / gain[1];
  if (since > 1.0) since = T(1.0);
  const T ramp = since * since * (2.0 - since) * (2.0 - since);
  const T approach = 1.0 - elementary::exp((depth - gain[2]) / gain[3]);
  const T slowed = 1.0 + gain[4] * force.squaredNorm();
  const T* yield = gain + (gains == kGuardedGains && depth > 0 ? kGains : 6);  // along y and z
  return {-gain[0] * ramp * approach / slowed + gain[5] * force.x(),
          yield[0] * force.y() + gain[8] + gain[10] * depth,
          yield[1] * force.z() + gain[9] + gain[11] * depth};
}

}  // namespace ferrule
