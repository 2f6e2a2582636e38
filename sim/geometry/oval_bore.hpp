// An oval bore: R(theta) = R + q cos 2(theta - theta_0), q = o/4, with o the ovality, largest less
// smallest diameter. To first order in q/c the wall is q cos 2(theta - theta_0) farther from the
// axis in the direction that the fibre is nearest to it: so for contacts on bore, cone and mouth
// (sim/geometry/contact_depth.hpp). Laws of the annulus (surface forces, drag, flow) are taken in
// the round bore that stretching across by c/(c + q) and c/(c - q) makes of the clearance's
// ellipse, which keeps axes straight: they miss the gap by 1.5 q^2/c at most, 2 nm for 0.1 um in a
// clearance of 0.5 um. The opening that an end rests over stays round.
#pragma once

#include "sim/geometry/energy.hpp"

namespace ferrule {

struct OvalBore {
  double amplitude = 0;                     // q [m], >= 0; 0: round
  Vector2d widest = Vector2d::UnitX();      // unit, theta_0
  Matrix2d stretch = Matrix2d::Identity();  // of the clearance's ellipse to a circle

  OvalBore() = default;
  // `ovality` o [m], clearance c [m] > 3 o/4, theta_0 as a unit vector.
  OvalBore(double ovality, double clearance, const Vector2d& direction) noexcept
      : amplitude(0.25 * ovality), widest(direction) {
    const Vector2d narrow(-widest.y(), widest.x());
    stretch = clearance / (clearance + amplitude) * widest * widest.transpose() +
              clearance / (clearance - amplitude) * narrow * narrow.transpose();
  }

  bool round() const noexcept { return amplitude == 0; }
  PoseVector stretched(const PoseVector& tip) const noexcept {
    return round() ? tip : PoseVector(tip.x, stretch * tip.e, stretch * tip.t);
  }
  // Derivatives by the stretched pose -> by the pose.
  PoseVector by_pose(const PoseVector& gradient) const noexcept { return stretched(gradient); }
  PoseMatrix by_pose(PoseMatrix m) const noexcept {
    m.xe = stretch * m.xe;
    m.xt = stretch * m.xt;
    m.ee = stretch * m.ee * stretch;
    m.et = stretch * m.et * stretch;
    m.tt = stretch * m.tt * stretch;
    return m;
  }
};

}  // namespace ferrule
