// Van der Waals attraction between fibre and bore, (1c).
//
// Half-spaces attract each other with H/(6 pi h^3) per area (Israelachvili 2011, ch. 13);
// integrated around the annulus of parallel axes at eccentricity e = c - h:
//   f = -H r c e / (2 (c^2 - e^2)^(5/2)),   potential -(H r c / 6) (c^2 - e^2)^(-3/2)
// with c and h enlarged by the roughness; in contact: sim/laws/corrected_range.hpp.
#pragma once

#include "sim/geometry/annulus.hpp"

namespace ferrule {

struct VanDerWaals {
  double hamaker;  // H [J], > 0; of the order of 1e-19 J for metals
};

// Force per inserted length at gap h < 2 c [m] (beyond c the near wall is the opposite one, and the
// force changes sign); zero potential at infinite clearance.
LineForce van_der_waals(const VanDerWaals& law, const Annulus& annulus, double h) noexcept;

}  // namespace ferrule
