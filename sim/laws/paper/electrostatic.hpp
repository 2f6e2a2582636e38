// Electrostatic attraction as printed, (2) of the paper:
//
//   F = -eps0 U^2 S / (2 h^2),  S = r theta l_f,  theta = 90 degrees,  h >= a_0,
//
// with eps0 = 8.85e-12 as in Table I. Below a_0: sim/laws/paper/range.hpp.
#pragma once

#include "sim/geometry/annulus.hpp"

namespace ferrule::printed {

struct Electrostatic {
  double voltage;  // U [V], >= 0
};

// Force per inserted length at any finite gap h [m]; zero potential at infinite gap.
LineForce electrostatic(const Electrostatic& law, const Annulus& annulus, double h) noexcept;

}  // namespace ferrule::printed
