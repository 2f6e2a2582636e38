// The minimum of the incremental potential of a step (sim/potential.hpp), by Newton's method.
//
// Walls, adhesion, friction and the printed laws are stiff and have kinks; the rest is smooth and
// soft. A Newton step takes friction as it is, stuck or slipping (sim/newton.hpp), and where it
// goes into or out of what is stiff it is cut to where the depths, computed on the way, say that
// the energy is least along it. The energy never rises.
#pragma once

#include "sim/newton.hpp"

namespace ferrule {

// A search for the minimum: where it has got to.
struct Minimum {
  Minimum(const World& world, const FrozenCoefficients& frozen, const PoseVector& start) noexcept
      : tip(start), there(world, frozen, start) {}

  PoseVector tip;
  Potential there;
  PoseVector curvature = {};  // Linearization::curvature
  int iterations = 0, evaluations = 1;
  bool converged = false;
  bool at_edge = false;  // beyond an edge is a surface that the side it rests against does not know
};

// Residual of a gradient [N], tilts weighed by the length that makes both stiffnesses equal.
double residual(const World& world, const PoseVector& gradient) noexcept;

// How far a move takes the end or the other end of the inserted length [m].
double travel_of(const World& world, const FrozenCoefficients& frozen,
                 const PoseVector& move) noexcept;

// Where a move from `tip` ends that goes along the wall and not straight; the same to first order.
PoseVector moved_along(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                       const PoseVector& move) noexcept;

// Shorter moves are none [m].
inline constexpr double kResolution = 1e-15;
// Of the sum of all forces: where so little is left and nothing lower is found, it is a minimum,
// and the Hessian of the step before does for the last step.
inline constexpr double kNearForce = 1e-7;

// The last Newton step, where it is so short that the forces change along it as the Hessian says
// and need no evaluation; false where it is not.
bool final_newton_step(const World& world, const FrozenCoefficients& frozen, const PoseVector& rest,
                       Minimum& found) noexcept;

// Goes on from where `found` is until it is converged, nothing lower is found, it is at an edge and
// not to go past it, or it has taken `most_evaluations`. Given the state `before` it also ends where
// something happens: the energy is concave, or the contacts are not those of that state.
void minimise(const World& world, const FrozenCoefficients& frozen, int most_evaluations,
              bool past_edges, Minimum& found, const State* before = nullptr) noexcept;

}  // namespace ferrule
