// Surface forces between tilted axes in closed form.
//
// Both axes are straight, so the vector e between them is linear along the inserted length, and
//   Q = C^2 - |e|^2,   C = c + roughness (6r)
// is a quadratic. With u and v the roots of Q at its two ends a and b, and d = |e_b - e_a|^2, the
// means over the length are
//   of Q^(-3/2):  2 (1/u + 1/v)/((u + v)^2 + d)
//   of Q^(-1/2):  2 atan(z)/(z (u + v)),   z^2 = d/(u + v)^2
// which lose no digits however small the tilt. They serve
//   van der Waals (1c)   w = -(H r C/6) Q^(-3/2): exact
//   electrostatic (2c)   w = -pi eps0 U^2 sqrt(r R') Q^(-1/2), R' = r + C: the exact cylinders to a
//     relative error below C^2/(24 r R') (3e-6 for a clearance of 0.5 um at r = 62.5 um)
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "sim/geometry/annulus.hpp"
#include "sim/geometry/energy.hpp"
#include "sim/laws/electrostatic.hpp"
#include "sim/laws/van_der_waals.hpp"

namespace ferrule {

// Energy per length w = -cubed Q^(-3/2) - single Q^(-1/2), as above.
struct TiltedAnnulus {
  double clearance = 0;  // C [m]
  double cubed = 0;      // [J m^2]
  double single = 0;     // [J]

  // Of the laws present.
  static TiltedAnnulus of(const VanDerWaals* van_der_waals, const Electrostatic* electrostatic,
                          const Annulus& annulus) noexcept;
};

// Means over a straight length as functions of the eccentricities at its ends: value and gradient
// law by law (van der Waals first), and the Hessian of their sum.
struct LineMean {
  std::array<double, 2> value{};                                        // [J/m]
  std::array<Vector2d, 2> by_a = {Vector2d::Zero(), Vector2d::Zero()};  // [N/m]
  std::array<Vector2d, 2> by_b = {Vector2d::Zero(), Vector2d::Zero()};  // [N/m]
  Matrix2d aa, ab, ba, bb;                                              // [N/m^2]
};

// |e_a| < C and |e_b| < C.
LineMean line_mean(const TiltedAnnulus& law, const Vector2d& e_a, const Vector2d& e_b) noexcept;

// The arms, ascending, at which the fibre's axis is `radius` from the bore's; none where it is not.
inline std::optional<std::array<double, 2>> arms_at(const PoseVector& tip, double radius) noexcept {
  const double a = tip.t.squaredNorm(), b = tip.e.dot(tip.t);
  const double d = tip.e.squaredNorm() - radius * radius, root = b * b - a * d;
  if (!(root > 0)) return std::nullopt;
  // Roots of a s^2 + 2 b s + d, without cancellation.
  const double q = b < 0 ? -b + std::sqrt(root) : -b - std::sqrt(root);
  return std::array{std::min(q / a, d / q), std::max(q / a, d / q)};
}

// Largest relative error of the electrostatic closed form: C^2/(24 r R').
double closed_form_error(const Annulus& annulus) noexcept;

}  // namespace ferrule
