// Weight of the manipulated length of fibre, equation (3) of the paper.
//
// Printed:    F = rho pi r^2 l_b      (a mass; the paper takes it as newtons: E2 in sim/README.md)
// Corrected:  F = rho pi r^2 l_b g    (g = 9.80665 m/s^2)
#pragma once

#include "sim/laws/form.hpp"

namespace ferrule {

inline constexpr double kStandardGravity = 9.80665;  // [m/s^2]

struct Gravity {
  Form form;
};

// The part of the fibre that the weight belongs to.
struct FibreMass {
  double radius;   // r [m], > 0
  double density;  // rho [kg/m^3], > 0
  double length;   // l_b [m], > 0
};

// Magnitude of the force along -y [N], > 0.
double gravity(const Gravity& law, const FibreMass& fibre) noexcept;

}  // namespace ferrule
