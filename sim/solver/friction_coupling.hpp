// The coupling of friction and pose within a step: the limits of friction are those of the contacts
// where the step ends, which are as deep as the limits let them be. No energy contains its own
// friction limit; so the limits are held while a minimum is sought (sim/solver/newton.hpp), and
// then moved, by Newton's method in limits and pose, to where they and the depths agree.
#pragma once

#include <optional>

#include "sim/solver/local_model.hpp"

namespace ferrule {

class FrictionCoupling {
 public:
  // With the errors of the limits of `frozen` against those of the contacts of `potential`, which
  // is at `tip`. What sticks has none.
  FrictionCoupling(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                   const Potential& potential) noexcept;
  // Without errors, for an end at `tip` near to where the limits were frozen. What has less slip
  // than `slides_at` of its limit sticks.
  FrictionCoupling(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                   double slides_at) noexcept;

  // The largest error, as a part of its limit [-].
  double largest_error() const noexcept;

 private:
  friend class CoupledModel;
  struct Place {
    bool slides = false;  // the rest is only set where it does
    double limit, stiffness, error;
    double per_depth;        // d limit / d depth [N/m]
    PoseVector depth_slope;  // of the depth, by the pose
    PoseVector direction;    // gradient of the friction for a limit of 1 N
  };
  static Place place(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                     int at, const FrictionLimit& now, const PoseVector& depth_slope,
                     double slides_at) noexcept;

  std::array<Place, kContactPlaces> place_;
};

// The local model with limits that follow the pose: its stiffness is
//   J = H + sum_j direction_j (d limit_j/d depth) depth_slope_j^T
// with the Hessian H at given limits, which `newton` has factored. The limits are eliminated:
//   change_j = error_j + (d limit_j/d depth) depth_slope_j . move,
//   move     = that at given limits - H^-1 sum_j direction_j change_j,
// a system of 2 by 2, the Schur complement, whose determinant is det J/det H. Refers to both.
class CoupledModel {
 public:
  CoupledModel(const NewtonStep& newton, const FrictionCoupling& coupling) noexcept;

  // Does the pose rest in a minimum at given limits, and do limits that follow leave it there?
  bool stable() const noexcept;

  // Of J. It falls to 0 at a fold, where the pose is lost [(N/m)^3 (N m/rad)^2].
  double determinant() const noexcept;

  // d of J d = -gradient.
  PoseVector solve(const PoseVector& gradient) const noexcept;

  // One Newton step in limits and pose: moves the limits of `frozen`, and returns the move of the
  // pose. A pose that is not a minimum at given limits may still be stable, as the limits fall when the
  // contact opens: as long as the determinant is positive. Nothing, and the limits as they are,
  // where it is not.
  std::optional<PoseVector> step(FrozenCoefficients& frozen) const noexcept;

 private:
  double limit_by(int place, const PoseVector& move) const noexcept;
  Vector2d solve_schur(const Vector2d& v) const noexcept;

  const NewtonStep& newton_;
  const std::array<FrictionCoupling::Place, kContactPlaces>& place_;
  std::array<PoseVector, kContactPlaces> response_;
  Matrix2d schur_ = Matrix2d::Identity();
};

}  // namespace ferrule
