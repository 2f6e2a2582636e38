// Van der Waals attraction between fibre and bore.
//
// Printed, (1) of the paper:  F = -H S / (24 pi h^3),  S = r theta l_f,  theta = 90 degrees,
//   h <= 100 nm. Beyond h = 100 nm the law is zero, reached by a smooth taper of 1 nm so that force
//   and potential stay continuous. Below a_0: sim/laws/printed_range.hpp.
// Corrected, (1c): half-spaces with H/(6 pi h^3) per area (Israelachvili 2011, ch. 13), integrated
//   around the annulus of parallel axes at eccentricity e = c - h:
//     f = -H r c e / (2 (c^2 - e^2)^(5/2)),   potential -(H r c / 6) (c^2 - e^2)^(-3/2)
//   with c and h enlarged by the roughness; in contact: sim/laws/corrected_range.hpp.
#pragma once

#include "sim/laws/annulus.hpp"
#include "sim/laws/form.hpp"

namespace ferrule {

struct VanDerWaals {
  Form form;
  double hamaker;  // H [J], > 0; of the order of 1e-19 J for metals
};

// Force per inserted length at gap h [m]. Printed: any finite h; zero potential beyond the taper.
// Corrected: h < 2 c (beyond c the near wall is the opposite one, and the force changes sign); zero
// potential at infinite clearance.
LineForce van_der_waals(const VanDerWaals& law, const Annulus& annulus, double h) noexcept;

}  // namespace ferrule
