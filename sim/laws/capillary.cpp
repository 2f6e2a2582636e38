#include "sim/laws/capillary.hpp"

#include <algorithm>
#include <cmath>

#include "sim/elementary.hpp"

namespace ferrule {
namespace {

// Half width of a bridge: the real root of x^3 + 6 R_e h x - 3 R_e A_l = 0, h >= 0.
double half_width(double volume, double radius, double h) noexcept {
  const double p = 2 * radius * h, q = 1.5 * radius * volume;           // x^3 + 3 p x - 2 q = 0
  const double u = elementary::cbrt(q + std::sqrt(q * q + p * p * p));  // Cardano
  double x = u - p / u;
  // Newton, for the digits that cancel where the bridge is much narrower than high.
  for (int i = 0; i < 2; ++i) x -= ((x * x + 3 * p) * x - 2 * q) / (3 * (x * x + p));
  return x;
}

// `h` from one mean plane to the other.
LineForce bridge_law(const Capillary& law, const Annulus& annulus, double h) noexcept {
  const double radius = annulus.fibre_radius * annulus.bore_radius / annulus.clearance();
  const double tension = 4 * law.surface_tension * elementary::cos(law.contact_angle);
  const double x = half_width(law.volume, radius, h);
  const double height = h + x * x / (2 * radius);
  const double force = -tension * x / height;
  return {-tension * x, force, tension * x / (height * height) * (2 - x * x / (radius * height))};
}

double half_width_at(const Capillary& law, const Annulus& annulus, double h) noexcept {
  return half_width(law.volume, annulus.fibre_radius * annulus.bore_radius / annulus.clearance(),
                    h);
}

}  // namespace

Capillary prepare(Capillary law, const Annulus& annulus) noexcept {
  law.rupture_half_width = half_width_at(law, annulus, law.rupture + annulus.roughness);
  law.film_half_width = half_width_at(law, annulus, 2 * law.film + annulus.roughness);
  return law;
}

double capillary_reach(const Capillary& law, bool bridge) noexcept {
  return bridge ? law.rupture : 2 * law.film;
}

double bridge_scale(const Capillary& law, const Annulus& annulus) noexcept {
  const double radius = annulus.fibre_radius * annulus.bore_radius / annulus.clearance();
  return 0.5 * elementary::cbrt(2.25 * law.volume * law.volume / radius) + annulus.roughness;
}

LineForce capillary(const Capillary& law, const Annulus& annulus, double h, bool bridge) noexcept {
  const double reach = capillary_reach(law, bridge);
  if (h >= reach) return {};
  LineForce force = bridge_law(law, annulus, std::max(h, 0.0) + annulus.roughness);
  if (h < 0) force = {force.potential - force.force * h, force.force, 0};
  // The potential is zero where the force ends.
  const double prepared = bridge ? law.rupture_half_width : law.film_half_width;
  force.potential +=
      4 * law.surface_tension * elementary::cos(law.contact_angle) *
      (prepared > 0 ? prepared : half_width_at(law, annulus, reach + annulus.roughness));
  return force;
}

}  // namespace ferrule
