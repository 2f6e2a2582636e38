#include "sim/drag.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ferrule {

DragCoefficients drag(const Drag& law, const Annulus& annulus, double eccentricity,
                      double length) noexcept {
  const double c = annulus.clearance() + annulus.roughness;
  const double e = std::min(eccentricity, c - std::max(annulus.roughness, kThinnestFilm));
  const double eps2 = (e / c) * (e / c), open = 1 - eps2, root = std::sqrt(open);
  const double slender = length / c, mu = law.viscosity * std::numbers::pi;
  const double squeeze = mu * annulus.fibre_radius * slender * slender * slender / (open * root);
  return {2 * mu * annulus.fibre_radius * length / (c * root), squeeze * (1 + 2 * eps2) / open,
          squeeze};
}

}  // namespace ferrule
