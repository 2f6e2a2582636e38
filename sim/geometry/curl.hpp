// Fibre curl: the natural curvature of a fibre that lies free of load.
//
// Held at s = L behind its end, the fibre of natural curvature 1/R is an arc: its end lies
//   L^2/(2 R)  aside (to first order in L/R) and tilts by  -L/R
// in a direction that turns with the fibre about its axis, the roll angle, which nobody sees when
// it is gripped. A cantilever bends so under a moment E I/R at its end: force at the end and
// stiffness are those of a straight fibre, held elsewhere. So curl is a matter of where the end is
// in free air, and of nothing else (the inserted part sags by l^2/(8 R), 0.3 nm over 100 um: left
// out). Telecom fibre has R of 4 m or more (ITU-T G.657, IEC 60793-1-34).
#pragma once

#include "sim/geometry/pose.hpp"

namespace ferrule {

// Where the free end of a curled fibre lies, less where that of a straight one would, for a radius
// R [m] > 0 or infinite, a length L [m] >= 0 and the unit direction it bends to.
inline Pose curl(double radius, double length, const Vector2d& direction) noexcept {
  const double turn = length / radius;
  return PoseVector(0, 0.5 * length * turn * direction, -turn * direction).full();
}

}  // namespace ferrule
