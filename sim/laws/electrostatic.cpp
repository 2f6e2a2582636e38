#include "sim/laws/electrostatic.hpp"

#include <cmath>
#include <numbers>

#include "sim/base/elementary.hpp"
#include "sim/laws/corrected_range.hpp"

namespace ferrule {
namespace {

LineForce cylinders_law(double voltage, const Annulus& annulus, double h) noexcept {
  const double c = annulus.clearance() + annulus.roughness;
  const double near = h + annulus.roughness, e = c - near;
  const double product = annulus.fibre_radius * (annulus.fibre_radius + c);  // r R
  // acosh(1 + t) with t >= 0 tiny, and its derivatives by e.
  const double t = near * (c + e) / (2 * product);
  const double root = std::sqrt(t * (2 + t));
  const double angle = elementary::log1p(t + root);
  const double strength = std::numbers::pi * kPermittivity * voltage * voltage;
  const double pull = e / (product * angle * angle * root);
  const double slope = (1 + e * e / (product * root) * (2 / angle + (1 + t) / root)) /
                       (product * angle * angle * root);
  return {-strength / angle, -strength * pull, strength * slope};
}

}  // namespace

LineForce electrostatic(const Electrostatic& law, const Annulus& annulus, double h) noexcept {
  return corrected::down_to_contact(
      [&](double gap) noexcept { return cylinders_law(law.voltage, annulus, gap); }, annulus, h);
}

}  // namespace ferrule
