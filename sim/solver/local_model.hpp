// The local model of a step's potential: its quadratic about a pose, with friction as a return
// mapping, and one block factorisation that solves it.
#pragma once

#include "sim/terms/friction.hpp"

namespace ferrule {

// The inverse of a symmetric matrix, and how many of its eigenvalues are negative.
inline int invert(const Matrix2d& m, Matrix2d& inverse) noexcept {
  const double determinant = m(0, 0) * m(1, 1) - m(1, 0) * m(0, 1), over = 1 / determinant;
  inverse.col(0) = Vector2d(m(1, 1), -m(1, 0)) * over;
  inverse.col(1) = Vector2d(-m(0, 1), m(0, 0)) * over;
  return determinant > 0 ? (m(0, 0) > 0 ? 0 : 2) : 1;
}

// Block LDL^T factorisation of a symmetric matrix h: the tilts are eliminated first, then y and z.
class BlockLdl {
 public:
  // Of h; returns how many of its eigenvalues are negative (Sylvester, 1852: as many as of its
  // pivots).
  int factor(const PoseMatrix& h) noexcept {
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

  // Of any h, with the magnitudes of its pivots' eigenvalues, no less than a part of those of
  // `least`: what pushes sideways on the axis must not slow the path along it.
  void factor_magnitudes(const PoseMatrix& h, const PoseMatrix& least) noexcept;

  // d of h d = -g.
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

// What forces, by columns, move the pose by, in equilibrium, where `model` solves h d = -g.
template <class Model>
Matrix5 follow_forces(const Model& model, const Matrix5& forces) noexcept {
  Matrix5 moves;
  for (int k = 0; k < 5; ++k) moves.col(k) = -model.solve(PoseVector(Pose(forces.col(k)))).full();
  return moves;
}

inline constexpr double kSlidingOn = 0.95;  // of its limit: what has just slid slides on
inline constexpr double kLinearTurn =
    0.1;  // of the sliding direction, that a model is good for [rad]
inline constexpr int kMaxReturnMappings = 8;  // until sticking and sliding contacts agree

enum class Pivots { magnitudes, as_they_are };

// A Newton step from `tip`: to the minimum of the quadratic of `smooth`, which is all but friction,
// together with friction by return mapping: every contact sticks or slides as it does where the
// step ends. With one round, or where more do not agree, as it does at `tip` (with `slides_on`,
// sliding where it just did).
//
// Where the Hessian is not positive definite the step takes the magnitudes of its pivots (towards
// lower energy) or the pivots as they are (towards where the gradient vanishes).
struct NewtonStep {
  Energy model;  // about the point the step begins at
  BlockLdl factors;
  int negative = 0;  // eigenvalues of the Hessian: directions in which the energy is concave
  bool convex = true;
  PoseVector move;
  double predicted_decrease = 0;  // minus the slope of the model along the move where it begins [J]

  NewtonStep(const World& world, const FrozenCoefficients& frozen, const Energy& smooth,
             const PoseVector& tip, int rounds = kMaxReturnMappings,
             Pivots pivots = Pivots::magnitudes, bool slides_on = false) noexcept;
};

// Is friction after a move from `tip` what it was taken to be there, with the friction `before`:
// sticking, or sliding on in the same direction? It slides where its elastic force is more than
// `slides_at` of its limit.
bool friction_agrees(const World& world, const std::array<FrozenFriction, kContactPlaces>& before,
                     const FrozenCoefficients& after, const PoseVector& tip, const PoseVector& move,
                     double slides_at) noexcept;

}  // namespace ferrule
