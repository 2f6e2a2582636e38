// What the holder feels when it moves: the stiffness of the fibre's end as seen from the hand.
//
// The step's potential (sim/potential.hpp) is (q - h)^T K_h (q - h)/2 + U(q) for the tip q and the
// hand h, K_h being the holder's stiffness. Where the fibre rests it is stationary,
//   K_h (q - h) + U'(q) = 0,   so   H dq = K_h dh   with   H = K_h + U''(q),
// and the wrench felt, K_h (q - h), changes by -K dh with
//   K = K_h - K_h H^-1 K_h.
// K is symmetric; 0 in free air, K_h against a rigid contact and never more than that where H is
// positive definite, as it is where the fibre rests; negative where attraction wins over the walls
// and a snap is near. Contacts, stuck friction and surface forces are all in U''.
//
// Over one step of dt drag and inertia resist too: they are part of the step's Hessian, and K of
// that step, K_dt, is at least K. What the step adds, B = dt (K_dt - K), is a damping [N s/m]: for
// a drag c in series with a holder k it is c k dt/(k dt + c), c where the holder is stiff.
#pragma once

#include "sim/scene.hpp"

namespace ferrule {

// K at `state` [N/m, N/rad, N m/rad] over a step of dt [s], >= 0; 0 is at rest, without drag and
// inertia. On the brink of a snap, where H is singular, the holder's own stiffness.
Matrix5 held_stiffness(const World& world, const State& state, double dt = 0) noexcept;

// The positions' part of K over many states of insertions into `scene`, tilts held by the hand
// (which is stiffer than letting them go).
struct StiffnessRange {
  double largest = 0;         // largest eigenvalue in any state [N/m], >= 0
  double smallest = 0;        // smallest: attraction where negative [N/m]
  double damping = 0;         // largest eigenvalue of B in any state [N s/m], >= 0
  State stiffest;             // where K is largest
  std::size_t states = 0;     // looked at
  std::size_t touching = 0;   // of these, with one contact or two
  std::size_t two_point = 0;  // of these, with end and side touching at once
};

// Deterministic, some thousand states: the start, the way to the axis and to the success depth,
// at half of it and at it pushes sideways and tilts to both sides (two-point contact), and the end
// pressed on the lead-in cone and on the front face. Every motion ends where the force at the
// holder, weight apart, exceeds limits.force. `dt` [s], > 0, is the period that B is for.
StiffnessRange insertion_stiffness(const Scene& scene, double dt);

}  // namespace ferrule
