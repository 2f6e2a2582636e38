// Electrostatic attraction between fibre and bore.
//
// Printed, (2) of the paper:  F = -eps0 U^2 S / (2 h^2),  S = r theta l_f,  theta = 90 degrees,
//   h >= a_0, with eps0 = 8.85e-12 as in Table I. Below a_0: sim/laws/printed_range.hpp.
// Corrected, (2c): exact for eccentric cylinders of parallel axes, e = c - h (Landau and Lifshitz,
//   vol. 8, sec. 3):
//     C' = 2 pi eps0 / acosh((R^2 + r^2 - e^2)/(2 r R)),   f = -(U^2/2) dC'/de
//   with c and h enlarged by the roughness; in contact: sim/laws/corrected_range.hpp.
#pragma once

#include "sim/laws/annulus.hpp"
#include "sim/laws/form.hpp"

namespace ferrule {

inline constexpr double kPermittivity = 8.8541878128e-12;  // eps0 [F/m], CODATA 2018

struct Electrostatic {
  Form form;
  double voltage;  // U [V], >= 0
};

// Force per inserted length at gap h [m]. Printed: any finite h, zero potential at infinite gap.
// Corrected: h < 2 c; the potential is that of the charged capacitor at constant voltage.
LineForce electrostatic(const Electrostatic& law, const Annulus& annulus, double h) noexcept;

}  // namespace ferrule
