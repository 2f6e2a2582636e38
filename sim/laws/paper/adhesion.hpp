// Adhesion at a closed contact as printed, (6) of the paper (Maugis-Dugdale):
//
//   F = K a^3 / r - lambda a^2 (pi w K^2 / r)^(1/3) (s + m^2 atan s),   s = sqrt(m^2 - 1)
//
// with the contact radius prescribed: a = 100 nm + 2 d for a penetration 0 <= d <= 10 nm, held at
// 120 nm beyond. As printed it attracts ever more with depth (E7 in docs/paper.md), so the wall
// (sim/laws/wall.hpp) begins where the prescription ends. The force jumps at d = 0; it is reached
// in a straight line over the last a_0 = 0.1 nm of the approach, -a_0 < d < 0.
#pragma once

#include "sim/geometry/annulus.hpp"
#include "sim/laws/adhesion.hpp"

namespace ferrule::printed {

struct Adhesion {
  double work_of_adhesion;  // w = 2 gamma_L [J/m^2], > 0: the work, not the surface energy gamma
  double maugis_lambda;     // lambda [-], 0.12 to 5.8
  double m;                 // c_ad / a [-], >= 1
  double reduced_modulus;   // K [Pa], > 0
  double radius;            // r [m], > 0: the fibre's
  // lambda (pi w K^2/r)^(1/3) (s + m^2 atan s) [N/m^2], of the values above, by prepare().
  double pull = 0;
};

Adhesion prepare(Adhesion law) noexcept;

// Largest penetration the law speaks of [m]: 10 nm.
inline constexpr double kDeepest = 10e-9;

// Prescribed contact radius a [m] at penetration d [m].
double contact_radius(double depth) noexcept;
// And its derivative by the penetration [-], to the right of its kinks.
double contact_radius_slope(double depth) noexcept;

// At penetration `depth` [m], any finite value. The law is prepared. Its branch is always 0.
AdhesionForce adhesion(const Adhesion& law, double depth) noexcept;

}  // namespace ferrule::printed
