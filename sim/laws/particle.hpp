// A particle on the wall of the bore: a hard bump, which takes up clearance.
//
// Of height h over the wall, in the direction u from the axis, s_p behind the entrance, and as wide
// as it is high: a paraboloid of the curvature 1/h,
//   b(x) = h - (x + s_p)^2/(2 h).
// sim/terms/particle_depth.hpp says how deep the fibre is in it; it pushes back as Hertz's sphere
// of the radius h does (sim/laws/wall.hpp), K being that of fibre and ferrule. It is stuck to the
// wall and as hard as that is, and has neither adhesion nor friction of its own; the wall that it
// presses the fibre to has both. A rigid upright fibre that passes it has the room c - h on its
// side: up to h = c nothing changes for one that is centred, up to 2 c it shifts aside, and beyond
// that it does not pass.
//
// Dirt is on fibres too. A bump there takes the same room from the fibre once both are in the bore,
// and besides has to come in over lead-in and mouth; a fibre is wiped before it goes in, a bore is
// hard to clean: what sits on the wall is modelled.
//
// How many and how high is *assumed*: IEC 61300-3-35 classifies the debris that a microscope sees
// on end faces, and nothing says what is in bores. Their number on the wall of the length that goes
// in, 2 pi R l, is Poisson distributed about N (N = 1 is 25 per mm^2 for 100 um of a bore of 126
// um); heights are log-normal, as sizes of dust are (Hinds, Aerosol Technology, 1999, chapter 4):
// the logarithm is normal about that of the median with the standard deviation sigma; places and
// directions are uniform. Only the highest of them acts.
#pragma once

#include <cmath>

#include "sim/geometry/pose.hpp"

namespace ferrule {

struct Particle {
  // What chance draws from.
  double number = 0;  // N [-], >= 0
  double median = 0;  // of the heights [m], > 0
  double spread = 0;  // sigma [-], >= 0
  // The one that is there.
  double height = NAN;   // h [m], >= 0; 0: none; NaN: chance decides
  double depth = 0;      // s_p [m], at least shallowest()
  double direction = 0;  // of u, from y to z [rad]
  // What follows for the one that is there (sim/scene/world_parameters.hpp).
  Vector2d outward = Vector2d::UnitX();  // u
  double reduced_modulus = 0;            // K [Pa]
};

inline constexpr double kHighestParticle = 1e-3;  // what is drawn higher is as high as this [m]

// The height [m] that the highest one exceeds in one trial of 50 at most: no more than N Q(z) are
// higher on average, Q(z) <= exp(-z^2/2)/2 being the normal distribution's tail. Of one that is
// there its own.
double unusual_height(const Particle& law) noexcept;

// The least s_p [m] for which the bump of height h, met by a rim that is rounded to rho, is in the
// bore and not on the cone, whose slope against the bore is `tangent` (0: none): with H = h + rho,
//   sqrt(2 h H),   or where the cone is steeper than sqrt(2 h/H),   H tangent/2 + h/tangent.
double shallowest(double height, double edge, double tangent) noexcept;

}  // namespace ferrule
