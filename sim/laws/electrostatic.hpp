// Electrostatic attraction between fibre and bore, (2c): exact for eccentric cylinders of parallel
// axes (Landau and Lifshitz, vol. 8, sec. 3), e = c - h:
//
//   C' = 2 pi eps0 / acosh((R^2 + r^2 - e^2)/(2 r R)),   f = -(U^2/2) dC'/de
//
// with c and h enlarged by the roughness; in contact: sim/laws/corrected_range.hpp. Valid for
// fields of at most kGreatestField across the closest gap, U/max(roughness, a_0).
#pragma once

#include "sim/geometry/annulus.hpp"

namespace ferrule {

inline constexpr double kPermittivity = 8.8541878128e-12;  // eps0 [F/m], CODATA 2018

// Beyond it no surface keeps its charge [V/m]: the current of field emission,
// 1.5e-6 E^2/phi exp(-6.8e9 phi^1.5/E) A/m^2 (Fowler and Nordheim 1928; work function phi in eV),
// is 1.5e10 A/m^2 at 5 eV; insulators break down far below.
inline constexpr double kGreatestField = 1e10;

struct Electrostatic {
  double voltage;  // U [V], >= 0
};

// Force per inserted length at gap h < 2 c [m]; the potential is that of the charged capacitor at
// constant voltage.
LineForce electrostatic(const Electrostatic& law, const Annulus& annulus, double h) noexcept;

}  // namespace ferrule
