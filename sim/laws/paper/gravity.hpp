// Weight as printed, (3) of the paper: F = rho pi r^2 l_b, a mass that the paper takes as newtons
// (E2 in docs/paper.md).
#pragma once

#include "sim/laws/gravity.hpp"

namespace ferrule::printed {

struct Gravity {};

// Magnitude of the force along -y [N], > 0.
inline double gravity(const Gravity&, const FibreMass& fibre) noexcept {
  return fibre.mass();
}

}  // namespace ferrule::printed
