#include "sim/laws/electrostatic.hpp"

#include <cmath>
#include <numbers>

#include "sim/laws/corrected_range.hpp"
#include "sim/laws/printed_range.hpp"

namespace ferrule {
namespace {

constexpr double kPermittivityTableI = 8.85e-12;  // eps0 [F/m]

LineForce cylinders_law(double voltage, const Annulus& annulus, double h) noexcept {
  const double c = annulus.clearance() + annulus.roughness;
  const double near = h + annulus.roughness, e = c - near;
  const double product = annulus.fibre_radius * (annulus.fibre_radius + c);  // r R
  // acosh(1 + t) with t >= 0 tiny, and its derivatives by e.
  const double t = near * (c + e) / (2 * product);
  const double root = std::sqrt(t * (2 + t));
  const double angle = std::log1p(t + root);
  const double strength = std::numbers::pi * kPermittivity * voltage * voltage;
  const double pull = e / (product * angle * angle * root);
  const double slope = (1 + e * e / (product * root) * (2 / angle + (1 + t) / root)) /
                       (product * angle * angle * root);
  return {-strength / angle, -strength * pull, strength * slope};
}

LineForce patch_law(const Electrostatic& law, const Annulus& annulus, double h) noexcept {
  const double strength = 0.5 * kPermittivityTableI * law.voltage * law.voltage *
                          annulus.fibre_radius * printed::kPatchAngle;
  return printed::down_to_contact(
      [&](double gap) noexcept -> LineForce {
        return {-strength / gap, -strength / (gap * gap), 2 * strength / (gap * gap * gap)};
      },
      h);
}

}  // namespace

LineForce electrostatic(const Electrostatic& law, const Annulus& annulus, double h) noexcept {
  if (law.form == Form::printed) return patch_law(law, annulus, h);
  return corrected::down_to_contact(
      [&](double gap) noexcept { return cylinders_law(law.voltage, annulus, gap); }, annulus, h);
}

}  // namespace ferrule
