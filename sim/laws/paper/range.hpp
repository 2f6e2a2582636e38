// Where the printed surface laws (1), (2), (4) end.
//
// They diverge as the gap h closes. The paper states h >= a_0 for (2); a_0 = 0.1 nm (Table I) is
// taken as the end of all three. Below it the atoms' repulsion, the steeper law, takes back what
// the attraction gains:
//   F(h) = F(a_0) (h/a_0)^7,   0 <= h <= a_0,
// to zero at h = 0, where the contact law (6) takes over (its work of adhesion is the work of these
// same forces), and in overlap. Force and potential are continuous. The exponent is ours: newtons
// at a_0 hold what weighs micronewtons, and the flatter the well's bottom, the less stiff it is
// there. Under a force f the fibre rests at h = a_0 (f/F(a_0))^(1/7), with the stiffness 7 f/h: 1e8
// N/m for 1 mN. A straight line has F(a_0)/a_0, up to 1e14 N/m, which leaves the pose no digits.
//
// The paper's law is for a patch of angular width theta = 90 degrees at a uniform gap.
#pragma once

#include <algorithm>
#include <numbers>

#include "sim/geometry/annulus.hpp"

namespace ferrule::printed {

inline constexpr double kPatchAngle = std::numbers::pi / 2.0;  // theta [rad], Table I

// `law(h)` returns the LineForce of the bare formula, valid for h >= a_0.
template <class Law>
LineForce down_to_contact(const Law& law, double h) noexcept {
  constexpr double a0 = kInteratomicDistance;
  if (h >= a0) return law(h);
  const LineForce end = law(a0);
  const double q = std::max(h, 0.0) / a0, q3 = q * q * q, q7 = q3 * q3 * q;
  return {end.potential + end.force * a0 / 8 * (1 - q7 * q), end.force * q7,
          7 * end.force / a0 * q3 * q3};
}

}  // namespace ferrule::printed
