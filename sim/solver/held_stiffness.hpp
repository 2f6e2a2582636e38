// The stiffness of the fibre's end as seen from the holder: how the wrench at the holder answers a
// change of the command.
//
// The step's potential (sim/terms/potential.hpp) is (q - h)^T K_h (q - h)/2 + U(q) for the tip q
// and the command h, K_h being the holder's stiffness. Where the fibre rests it is stationary,
//   K_h (q - h) + U'(q) = 0,   so   H dq = K_h dh   with   H = K_h + U''(q),
// and the wrench at the holder, K_h (q - h), changes by -K dh with
//   K = K_h - K_h H^-1 K_h.
// K is symmetric; 0 in free air, K_h against a rigid contact and never more than that where H is
// positive definite, as it is where the fibre rests; negative where attraction wins over the walls
// and a snap is near. Contacts, stuck friction and surface forces are all in U''. A contact that
// slides holds its friction limit as it is: how that grows with the load (friction_coupling.hpp)
// would make K unsymmetric, and is left out.
//
// Over one step of dt drag and inertia resist too: they are part of the step's Hessian, and K of
// that step, K_dt, is at least K. What the step adds, B = dt (K_dt - K), is a damping [N s/m]: for
// a drag c in series with a holder k it is c k dt/(k dt + c), c where the holder is stiff. What the
// hand's own motion damps of the fibre's bending (sim/model/holder.hpp), eta/(omega_1 dt) of K, is
// left out.
#pragma once

#include "sim/model/world.hpp"

namespace ferrule {

// K at `state` [N/m, N/rad, N m/rad] over a step of dt [s], >= 0; 0 is at rest, without drag and
// inertia. On the brink of a snap, where H is singular, the holder's own stiffness.
Matrix5 held_stiffness(const World& world, const State& state, double dt = 0) noexcept;

}  // namespace ferrule
