// Axial pull of the meniscus at the bore's mouth when liquid fills the gap.
//
//   F_x = -2 pi r gamma_L cos(theta_c): wetting liquid pulls the fibre in, once its end is inside.
#pragma once

#include <numbers>

#include "sim/base/elementary.hpp"

namespace ferrule {

struct Meniscus {
  double surface_tension;  // gamma_L [N/m], > 0
  double contact_angle;    // theta_c [rad], 0 <= theta_c < pi/2
};

// Magnitude of the pull [N] on a fibre of the given radius [m].
inline double meniscus(const Meniscus& law, double fibre_radius) noexcept {
  return 2 * std::numbers::pi * fibre_radius * law.surface_tension *
         elementary::cos(law.contact_angle);
}

}  // namespace ferrule
