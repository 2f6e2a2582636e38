// Van der Waals attraction as printed, (1) of the paper:
//
//   F = -H S / (24 pi h^3),  S = r theta l_f,  theta = 90 degrees,  h <= 100 nm.
//
// Beyond h = 100 nm the law is zero, reached by a smooth taper of 1 nm so that force and potential
// stay continuous. Below a_0: sim/laws/paper/range.hpp.
#pragma once

#include "sim/geometry/annulus.hpp"

namespace ferrule::printed {

struct VanDerWaals {
  double hamaker;  // H [J], > 0
};

// Force per inserted length at any finite gap h [m]; zero potential beyond the taper.
LineForce van_der_waals(const VanDerWaals& law, const Annulus& annulus, double h) noexcept;

}  // namespace ferrule::printed
