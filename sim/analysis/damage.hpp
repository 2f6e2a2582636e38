// Forces at which a fibre takes damage: where a limit on the force comes from.
//
// For forces at the end of the free fibre, of radius r, Young's modulus E, free length L:
//   buckling   axial: Euler's load, clamped-free, pi^2 E I/(4 L^2), I = pi r^4/4
//   bending    sideways: the stress F L r/I at the holder reaches the stress that is allowed,
//              F = pi r^3 sigma/(4 L)
// and for the end's edge, rounded by rho, on a wall (Hertz, equivalent radius R = sqrt(rho r)):
//   ring       the tension around the contact, (1 - 2 nu) p_0/3 with p_0^3 = 6 F E*^2/(pi^3 R^2)
//              (Johnson 1985, "Contact Mechanics", 3.4), reaches the stress that is allowed
//   chipping   F = T_e rho: the edge breaks off under a force in proportion to its distance from
//              the edge (Morrell and Gant 2001, "Edge chipping of hard materials")
#pragma once

#include "sim/model/world.hpp"

namespace ferrule {

// T_e of glass [N/m]: some 100 N/mm (Morrell and Gant); assumed for silica.
inline constexpr double kEdgeToughness = 1e5;

struct DamageForces {
  double buckling, bending;  // [N]; infinite for a rigid hand, which neither buckles nor bends
  double ring, chipping;     // [N]
};

// `stress` that is allowed [Pa], > 0; `edge` radius rho [m], > 0; Poisson's ratio of the fibre.
DamageForces damage_forces(const World& world, double reduced_modulus, double poisson,
                           double stress, double edge) noexcept;

}  // namespace ferrule
