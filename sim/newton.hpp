// Steps to the minimum of an energy of the pose.
#pragma once

#include "sim/potential.hpp"

namespace ferrule {

// The inverse of a symmetric matrix, and how many of its eigenvalues are negative.
inline int invert(const Matrix2d& m, Matrix2d& inverse) noexcept {
  const double determinant = m(0, 0) * m(1, 1) - m(1, 0) * m(0, 1), over = 1 / determinant;
  inverse.col(0) = Vector2d(m(1, 1), -m(1, 0)) * over;
  inverse.col(1) = Vector2d(-m(0, 1), m(0, 0)) * over;
  return determinant > 0 ? (m(0, 0) > 0 ? 0 : 2) : 1;
}

// A symmetric matrix with the tilts eliminated, then y and z: for solving h d = -g.
class Eliminated {
 public:
  // How many of the eigenvalues of h are negative (Sylvester, 1852: as many as of its pivots).
  int of(const PoseMatrix& h) noexcept {
    const int tt = invert(h.tt, over_tt_);
    et_over_tt_ = h.et * over_tt_;
    xt_over_tt_ = over_tt_ * h.xt;
    const int ee = invert(h.ee - et_over_tt_ * h.et.transpose(), over_ee_);
    const Vector2d xe = h.xe - et_over_tt_ * h.xt;
    xe_over_ee_ = over_ee_ * xe;
    const double xx = h.xx - xt_over_tt_.dot(h.xt) - xe_over_ee_.dot(xe);
    over_xx_ = 1 / xx;
    return tt + ee + (xx > 0 ? 0 : 1);
  }

  // Of any h, with the magnitudes of the pivots' eigenvalues, no less than those of `least`: what
  // pushes sideways on the axis must not slow the way along it.
  void of_magnitudes(const PoseMatrix& h, const PoseMatrix& least) noexcept;

  PoseVector solve(const PoseVector& g) const noexcept {
    const Vector2d ge = g.e - et_over_tt_ * g.t;
    const double x = -(g.x - xt_over_tt_.dot(g.t) - xe_over_ee_.dot(ge)) * over_xx_;
    const Vector2d e = -(over_ee_ * ge) - x * xe_over_ee_;
    return {x, e, -(over_tt_ * g.t) - x * xt_over_tt_ - et_over_tt_.transpose() * e};
  }

  double determinant() const noexcept {  // [(N/m)^3 (N m/rad)^2]
    return 1 / (over_tt_.determinant() * over_ee_.determinant() * over_xx_);
  }

 private:
  Matrix2d over_tt_, over_ee_, et_over_tt_;
  Vector2d xt_over_tt_, xe_over_ee_;
  double over_xx_ = 0;
};

inline constexpr double kSlipsOn = 0.95;  // what has just slipped slips on, whatever its limit does
inline constexpr double kTurned = 0.1;    // of the slip's direction: about which it is linear [rad]
inline constexpr int kFrictionRounds = 8;  // of stuck and slipping contacts, until they agree

// A Newton step from `tip`: to where the quadratic of `smooth`, all but friction, and friction as
// it is where the step ends, stuck or slipping, have their minimum together; in one round, or where
// more do not agree, friction as it is at `tip` (or, `slips_on`, slipping where it just did).
//
// Where the Hessian is not positive definite the step takes the magnitudes of its pivots, or,
// towards where the gradient vanishes, whatever the energy does there, the pivots as they are.
enum class Pivots { magnitudes, as_they_are };

struct NewtonStep {
  Energy model;  // about the point the step begins at
  Eliminated hessian;
  int falling = 0;  // directions in which the energy is concave
  bool convex = true;
  PoseVector move;
  double fall = 0;  // the slope along the move where it begins, of its model; > 0: down [J]

  NewtonStep(const World& world, const FrozenCoefficients& frozen, const Energy& smooth,
             const PoseVector& tip, int rounds = kFrictionRounds,
             Pivots pivots = Pivots::magnitudes, bool slips_on = false) noexcept;
};

}  // namespace ferrule
