// Electrostatic attraction between fibre and bore, (2c): exact for eccentric cylinders of parallel
// axes (Landau and Lifshitz, vol. 8, sec. 3), e = c - h:
//
//   C' = 2 pi eps0 / acosh((R^2 + r^2 - e^2)/(2 r R)),   f = -(U^2/2) dC'/de
//
// with c and h enlarged by the roughness; in contact: sim/laws/corrected_range.hpp. Valid for fields
// of at most kGreatestField across the closest gap, U/max(roughness, a_0).
#pragma once

#include "sim/laws/annulus.hpp"

namespace ferrule {

inline constexpr double kPermittivity = 8.8541878128e-12;  // eps0 [F/m], CODATA 2018

// Beyond it no surface keeps its atoms [V/m]: of all metals tungsten bears most before they leave as
// ions, 57 V/nm (Tsong 1990, "Atom-probe field ion microscopy"); insulators break down far below.
inline constexpr double kGreatestField = 6e10;

struct Electrostatic {
  double voltage;  // U [V], >= 0
};

// Force per inserted length at gap h < 2 c [m]; the potential is that of the charged capacitor at
// constant voltage.
LineForce electrostatic(const Electrostatic& law, const Annulus& annulus, double h) noexcept;

}  // namespace ferrule
