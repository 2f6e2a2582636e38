#include "sim/laws/van_der_waals.hpp"

#include <cmath>

#include "sim/laws/corrected_range.hpp"

namespace ferrule {
namespace {

LineForce annulus_law(double hamaker, const Annulus& annulus, double h) noexcept {
  const double c = annulus.clearance() + annulus.roughness;
  const double near = h + annulus.roughness;  // c - e, exact where it is small
  const double e = c - near;
  const double q = near * (c + e);  // c^2 - e^2
  const double strength = hamaker * annulus.fibre_radius * c / (q * std::sqrt(q));
  return {-strength / 6, -0.5 * strength * e / q, 0.5 * strength * (1 / q + 5 * e * e / (q * q))};
}

}  // namespace

LineForce van_der_waals(const VanDerWaals& law, const Annulus& annulus, double h) noexcept {
  return corrected::down_to_contact(
      [&](double gap) noexcept { return annulus_law(law.hamaker, annulus, gap); }, annulus, h);
}

}  // namespace ferrule
