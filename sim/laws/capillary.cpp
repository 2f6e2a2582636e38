#include "sim/laws/capillary.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/base/elementary.hpp"

namespace ferrule {
namespace {

// Numbers at several gaps.
using AtGaps = std::array<double, kMostNodes>;

// Half widths of bridges: the real roots of x^3 + 6 R_e h x - 3 R_e A_l = 0, h >= 0. Gap by gap the
// operations wait for each other; in loops over all gaps they do not.
void half_widths(double volume, double radius, std::size_t count, const AtGaps& h,
                 AtGaps& x) noexcept {
  const double q = 1.5 * radius * volume;  // x^3 + 3 p x - 2 q = 0
  for (std::size_t i = 0; i < count; ++i) {
    const double p = 2 * radius * h[i];
    x[i] = q + std::sqrt(q * q + p * p * p);
  }
  for (std::size_t i = 0; i < count; ++i) x[i] = elementary::cbrt(x[i]);  // Cardano
  for (std::size_t i = 0; i < count; ++i) {
    const double p = 2 * radius * h[i];
    double root = x[i] - p / x[i];
    // Newton, for the digits that cancel where the bridge is much narrower than high.
    for (int n = 0; n < 2; ++n)
      root -= ((root * root + 3 * p) * root - 2 * q) / (3 * (root * root + p));
    x[i] = root;
  }
}

double half_width(double volume, double radius, double h) noexcept {
  AtGaps x;
  half_widths(volume, radius, 1, {h}, x);
  return x[0];
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

double capillary_range(const Capillary& law, bool bridge) noexcept {
  return bridge ? law.rupture : 2 * law.film;
}

double bridge_scale(const Capillary& law, const Annulus& annulus) noexcept {
  const double radius = annulus.fibre_radius * annulus.bore_radius / annulus.clearance();
  return 0.5 * elementary::cbrt(2.25 * law.volume * law.volume / radius) + annulus.roughness;
}

void capillary(const Capillary& law, const Annulus& annulus, bool bridge,
               std::span<const double> gaps, std::span<LineForce> forces) noexcept {
  const double radius = annulus.fibre_radius * annulus.bore_radius / annulus.clearance();
  const double tension = 4 * law.surface_tension * elementary::cos(law.contact_angle);
  const double range = capillary_range(law, bridge);
  const double prepared = bridge ? law.rupture_half_width : law.film_half_width;
  // The potential is zero where the force ends.
  const double end =
      tension * (prepared > 0 ? prepared : half_width_at(law, annulus, range + annulus.roughness));
  AtGaps distance, x;  // from one mean plane to the other; half width
  for (std::size_t i = 0; i < gaps.size(); ++i)
    distance[i] = std::max(gaps[i], 0.0) + annulus.roughness;
  half_widths(law.volume, radius, gaps.size(), distance, x);
  for (std::size_t i = 0; i < gaps.size(); ++i) {
    const double height = distance[i] + x[i] * x[i] / (2 * radius);
    const double force = -tension * x[i] / height;
    const double slope = tension * x[i] / (height * height) * (2 - x[i] * x[i] / (radius * height));
    const double h = gaps[i], potential = -tension * x[i];
    if (h >= range)
      forces[i] = {};
    else if (h < 0)
      forces[i] = {potential - force * h + end, force, 0};
    else
      forces[i] = {potential + end, force, slope};
  }
}

LineForce capillary(const Capillary& law, const Annulus& annulus, double h, bool bridge) noexcept {
  LineForce force;
  if (h < capillary_range(law, bridge)) capillary(law, annulus, bridge, {&h, 1}, {&force, 1});
  return force;
}

}  // namespace ferrule
