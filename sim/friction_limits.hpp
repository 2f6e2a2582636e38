// The limits of friction within a step: those of the contacts where the step ends, which are as
// deep as the limits let them be. Energies do not know this, friction being none; so the limits are
// held while a minimum is sought (sim/minimum.hpp), and then moved, by Newton's method, to where
// they and the depths agree.
#pragma once

#include <optional>

#include "sim/newton.hpp"

namespace ferrule {

class FrictionLimits {
 public:
  // By how much the limits of `frozen` miss those of the contacts of the potential `there`, which
  // is at `tip`. What is stuck has none.
  FrictionLimits(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                 const Potential& there) noexcept;
  // They miss nothing, with the end at `tip`, near to where they were frozen. What is stuck has
  // none: what rubs with less than this part of its limit.
  FrictionLimits(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                 double slips_at) noexcept;

  // The largest miss, as a part of its limit.
  double largest_miss() const noexcept;

  // Determinant of what holds the pose, the limits giving way as the contacts do: that of the model
  // of `newton` and the limits together. It falls to 0 where the pose is lost.
  double determinant(const NewtonStep& newton) const noexcept;

  // Moves the limits of `frozen` to where they miss nothing after the whole move: that of `newton`
  // to where the forces balance, its model's but for the limits, and what changing them adds: that
  // move. What is no minimum of given limits may still be stable, as the limits give way when the
  // contact does: as long as the determinant of both together is positive. Nothing, and the limits
  // as they are, where it is not.
  std::optional<PoseVector> settle(const NewtonStep& newton,
                                   FrozenCoefficients& frozen) const noexcept;

 private:
  struct Place {
    bool slips = false;  // the rest is only set where it does
    double limit, stiffness, miss;
    double per_depth;              // d limit / d depth [N/m]
    PoseVector depth_slope, pull;  // depth by the pose; gradient of the friction for a limit of 1 N
  };
  static Place place(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                     int at, const FrictionLimit& is, const PoseVector& depth_slope,
                     double slips_at) noexcept;
  Matrix5 together(const NewtonStep& newton) const noexcept;
  std::optional<PoseVector> settle_together(const NewtonStep& newton,
                                            FrozenCoefficients& frozen) const noexcept;

  std::array<Place, kContactPlaces> place_;
};

}  // namespace ferrule
