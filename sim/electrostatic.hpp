// Electrostatic attraction between fibre and bore, equation (2) of the paper.
//
// Printed:  F = -eps0 U^2 S / (2 h^2),  S = r theta l_f,  theta = 90 degrees,  h >= a_0,
//   with eps0 = 8.85e-12 as in Table I. Below a_0: sim/printed_range.hpp.
#pragma once

#include "sim/annulus.hpp"
#include "sim/form.hpp"

namespace ferrule {

struct Electrostatic {
  Form form;
  double voltage;  // U [V], >= 0
};

// Force per inserted length at gap h [m]. Any finite h. Zero potential at infinite gap.
LineForce electrostatic(const Electrostatic& law, const Annulus& annulus, double h) noexcept;

}  // namespace ferrule
