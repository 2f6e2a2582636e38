// The minimum of the incremental potential of a step (sim/terms/potential.hpp), by Newton's method.
//
// Walls, adhesion, friction and the printed laws are stiff and have kinks; the rest is smooth and
// soft. A Newton step takes friction by return mapping (sim/solver/local_model.hpp). Where it goes
// into or out of a nonsmooth term it is cut to where the depths, computed along it, say that the
// energy is least (sim/solver/line_search.hpp). The energy never rises.
#pragma once

#include "sim/solver/local_model.hpp"
#include "sim/solver/trace.hpp"

namespace ferrule {

// Where a search for the minimum has got to.
struct Iterate {
  Iterate(const World& world, const FrozenCoefficients& frozen, const PoseVector& start,
          StepTrace* to = nullptr) noexcept
      : tip(start), potential(world, frozen, start), trace(to) {}

  PoseVector tip;
  Potential potential;        // at the tip
  PoseVector curvature = {};  // Linearization::curvature
  int iterations = 0, evaluations = 1;
  bool converged = false;
  bool at_edge = false;  // beyond an edge is a surface that the side it rests against does not know
  bool spent = false;    // all evaluations that it was given
  StepTrace* trace;      // or null
};

// Residual of a gradient [N], tilts weighed by the length that makes both stiffnesses equal.
double residual(const World& world, const PoseVector& gradient) noexcept;

// How far a move takes the end or the other end of the inserted length [m].
double length_of(const World& world, const FrozenCoefficients& frozen,
                 const PoseVector& move) noexcept;

// Of the iterate, for a trace; with the `move` that led to it, or none.
TraceEntry entry(const Iterate& iterate, SolverStage stage, const char* reason, double part,
                 double move = NAN) noexcept;
inline void note(const Iterate& iterate, SolverStage stage, const char* reason) noexcept {
  if (iterate.trace) iterate.trace->add(entry(iterate, stage, reason, iterate.trace->part));
}
inline void note(const Iterate& iterate, SolverStage stage, const char* reason, const World& world,
                 const PoseVector& move) noexcept {
  if (iterate.trace)
    iterate.trace->add(entry(iterate, stage, reason, iterate.trace->part,
                             move.length() / world.annulus.clearance()));
}

// The retraction: where a move from `tip` ends that goes along the wall and not straight; the same
// to first order.
PoseVector retract(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                   const PoseVector& move) noexcept;

// Shorter moves are none [m].
inline constexpr double kResolution = 1e-15;
// Of the sum of all forces: where so little is left and nothing lower is found, it is a minimum,
// and the Hessian of the step before does for the last step.
inline constexpr double kNearForce = 1e-7;

// The Newton step of the iterate towards where the gradient vanishes, with friction as it is there.
NewtonStep stationary_step(const World& world, const FrozenCoefficients& frozen,
                           const Iterate& iterate) noexcept;

// The last Newton step, with the friction `before` at its start, where it needs no evaluation: it
// is so short that the forces change along it as the Hessian says, and every contact goes on
// sticking or sliding. False where it is not.
bool final_newton_step(const World& world, const std::array<FrozenFriction, kContactPlaces>& before,
                       const FrozenCoefficients& frozen, const PoseVector& move,
                       Iterate& iterate) noexcept;

// Goes on until the iterate is converged, nothing lower is found, it is at an edge and not to go
// past it, or it has taken `max_evaluations`. Given the state `before` it also ends where something
// happens: the energy is concave, or the contact set is not that of the state.
void minimise(const World& world, const FrozenCoefficients& frozen, int max_evaluations,
              bool past_edges, Iterate& iterate, const State* before = nullptr) noexcept;

}  // namespace ferrule
