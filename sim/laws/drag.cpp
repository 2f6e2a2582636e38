#include "sim/laws/drag.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ferrule {

DragCoefficients drag(const Drag& law, const Annulus& annulus, double eccentricity,
                      double length) noexcept {
  const double c = annulus.clearance() + annulus.roughness;
  const double e = std::min(eccentricity, c - std::max(annulus.roughness, kThinnestFilm));
  const double per_c = 1 / c, eps = e * per_c, eps2 = eps * eps;
  const double open = 1 - eps2, root = std::sqrt(open), per_cube = 1 / (open * root);
  const double slender = length * per_c;
  const double strength = law.viscosity * std::numbers::pi * annulus.fibre_radius * per_cube;
  const double squeeze = strength * slender * slender * slender;
  return {2 * strength * slender * open, squeeze * (1 + 2 * eps2) * root * per_cube, squeeze};
}

}  // namespace ferrule
