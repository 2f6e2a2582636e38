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

  // Determinant of the Jacobian of limits and pose together, the Hessian of which is that of
  // `newton`. It falls to 0 at a fold, where the pose is lost.
  double determinant(const NewtonStep& newton) const noexcept;

  // One Newton step in limits and pose, for what `newton` has of the pose at given limits: moves
  // the limits of `frozen`, and returns the move of the pose. What is no minimum at given limits
  // may still be stable, as the limits fall when the contact opens: as long as the determinant is
  // positive. Nothing, and the limits as they are, where it is not.
  std::optional<PoseVector> newton_step(const NewtonStep& newton,
                                        FrozenCoefficients& frozen) const noexcept;

 private:
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
  Matrix5 jacobian(const NewtonStep& newton) const noexcept;
  std::optional<PoseVector> monolithic_step(const NewtonStep& newton,
                                            FrozenCoefficients& frozen) const noexcept;

  std::array<Place, kContactPlaces> place_;
};

}  // namespace ferrule
