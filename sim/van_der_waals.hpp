// Van der Waals attraction between fibre and bore, equation (1) of the paper.
//
// Printed:  F = -H S / (24 pi h^3),  S = r theta l_f,  theta = 90 degrees,  h <= 100 nm.
//   The printed factor is 24 pi; two half-spaces have 6 pi (Israelachvili 2011, ch. 13): see E1 in
//   sim/README.md. Beyond h = 100 nm the law is zero, reached by a smooth taper of 1 nm so that
//   force and potential stay continuous. Below a_0: sim/printed_range.hpp.
#pragma once

#include "sim/annulus.hpp"
#include "sim/form.hpp"

namespace ferrule {

struct VanDerWaals {
  Form form;
  double hamaker;  // H [J], > 0; of the order of 1e-19 J for metals
};

// Force per inserted length at gap h [m]. Any finite h. Zero potential beyond the taper.
LineForce van_der_waals(const VanDerWaals& law, const Annulus& annulus, double h) noexcept;

}  // namespace ferrule
