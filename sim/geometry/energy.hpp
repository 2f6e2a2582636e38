// An energy as a function of the fibre's pose, with gradient and Hessian, and how energies of
// points of the fibre add to it.
#pragma once

#include <cmath>

#include "sim/geometry/pose.hpp"

namespace ferrule {

using Eigen::Matrix3d;

// Eccentricity of the fibre's axis at arm s behind the end [m]: the vector from the bore's axis.
inline Vector2d eccentricity(const PoseVector& tip, double s) noexcept {
  return tip.e + s * tip.t;
}

// The arm s of a point of the axis, and its derivative by x: 0 for a point of the fibre, -1 for the
// place that a fixed point of the ferrule touches.
struct Arm {
  double length = 0;  // [m]
  double per_x = 0;
};

// Adds the Hessian of stiffness l^2/2, the length l having the derivative `slope` by the pose.
inline void add_square(PoseMatrix& hessian, double stiffness, const PoseVector& slope) noexcept {
  const PoseVector pull = stiffness * slope;
  hessian.xx += pull.x * slope.x;
  hessian.xe += pull.x * slope.e;
  hessian.xt += pull.x * slope.t;
  hessian.ee += pull.e * slope.e.transpose();
  hessian.et += pull.e * slope.t.transpose();
  hessian.tt += pull.t * slope.t.transpose();
}

struct Energy {
  double value = 0;     // [J]
  PoseVector gradient;  // [N, N m]
  PoseMatrix hessian;   // [N/m, N/rad, N m/rad]
  // Sums of the magnitudes of all energies and forces in it [J], [N]: what rounding is relative to.
  double value_scale = 0, force_scale = 0;

  // An energy of the eccentricity at `arm`, given its derivatives by that; `tilt` is the pose's.
  void add_across(const Vector2d& tilt, Arm arm, const Vector2d& slope,
                  const Matrix2d& curve) noexcept {
    gradient.e += slope;
    gradient.t += arm.length * slope;
    hessian.ee += curve;
    hessian.et += arm.length * curve;
    hessian.tt += arm.length * arm.length * curve;
    if (arm.per_x == 0) return;
    const Vector2d turned = arm.per_x * (curve * tilt);
    gradient.x += arm.per_x * slope.dot(tilt);
    hessian.xx += arm.per_x * tilt.dot(turned);
    hessian.xe += turned;
    hessian.xt += arm.length * turned + arm.per_x * slope;
  }

  // An energy of the point (x + offset.tilt, eccentricity at `arm`), given its derivatives by that.
  void add_point(double arm, const Vector2d& offset, const Vector3d& slope,
                 const Matrix3d& curve) noexcept {
    const double xx = curve(0, 0);
    const Vector2d xe = curve.block<2, 1>(1, 0), across = slope.tail<2>();
    const Matrix2d ee = curve.bottomRightCorner<2, 2>(), mixed = xe * offset.transpose();
    gradient.x += slope[0];
    gradient.e += across;
    gradient.t += slope[0] * offset + arm * across;
    hessian.xx += xx;
    hessian.xe += xe;
    hessian.xt += xx * offset + arm * xe;
    hessian.ee += ee;
    hessian.et += mixed + arm * ee;
    hessian.tt +=
        xx * offset * offset.transpose() + arm * (mixed + mixed.transpose()) + arm * arm * ee;
  }
};

}  // namespace ferrule
