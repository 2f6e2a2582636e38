// Where the printed surface laws (1), (2), (4) end.
//
// They diverge as the gap h closes. The paper states h >= a_0 for (2); a_0 = 0.1 nm (Table I) is
// taken as the end of all three. Below it the force falls in a straight line from its value at a_0
// to zero at h = 0, where the contact law (6) takes over (its work of adhesion is the work of these
// same forces), and stays zero in overlap. Force and potential are continuous.
//
// The paper's law is for a patch of angular width theta = 90 degrees at a uniform gap.
#pragma once

#include <numbers>

#include "sim/laws/annulus.hpp"

namespace ferrule::printed {

inline constexpr double kPatchAngle = std::numbers::pi / 2.0;  // theta [rad], Table I

// `law(h)` returns the LineForce of the bare formula, valid for h >= a_0.
template <class Law>
LineForce down_to_contact(const Law& law, double h) noexcept {
  constexpr double a0 = kInteratomicDistance;
  if (h >= a0) return law(h);
  const LineForce end = law(a0);
  if (h <= 0) return {end.potential + 0.5 * end.force * a0, 0.0, 0.0};
  return {end.potential + 0.5 * end.force * (a0 * a0 - h * h) / a0, end.force * h / a0,
          end.force / a0};
}

}  // namespace ferrule::printed
