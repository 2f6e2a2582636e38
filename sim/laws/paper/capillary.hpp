// Capillary attraction as printed, (4) of the paper:
//
//   F = -2 gamma_L l_f (1 - (h - 2 e) / (2 r_1)) cos(theta_c)
//
// with the meniscus radius r_1 = h / (2 cos(theta_c)). The paper prints cos(theta) there, with
// theta its angular range of 90 degrees, which would make r_1 infinite; the contact angle is meant
// (E3 in docs/paper.md). The printed layer never lets go (E4). Below a_0:
// sim/laws/paper/range.hpp. The potential is zero where two films meet, h = 2 e.
#pragma once

#include "sim/geometry/annulus.hpp"

namespace ferrule::printed {

struct Capillary {
  double surface_tension;  // gamma_L [N/m], > 0
  double contact_angle;    // theta_c [rad], 0 <= theta_c < pi/2 (wetting)
  double film;             // e, thickness of the liquid layer [m], > 0
};

// Force per inserted length at any finite gap h [m].
LineForce capillary(const Capillary& law, double h) noexcept;

}  // namespace ferrule::printed
