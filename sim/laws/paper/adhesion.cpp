#include "sim/laws/paper/adhesion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/base/elementary.hpp"

namespace ferrule::printed {
namespace {

constexpr double kRadiusAtTouch = 100e-9;  // [m]
constexpr double kRadiusPerDepth = 2.0;    // 20 nm over 10 nm

}  // namespace

double contact_radius(double depth) noexcept {
  return kRadiusAtTouch + kRadiusPerDepth * std::clamp(depth, 0.0, kDeepest);
}

Adhesion prepare(Adhesion law) noexcept {
  const double s = std::sqrt((law.m - 1) * (law.m + 1));
  law.pull = law.maugis_lambda *
             elementary::cbrt(std::numbers::pi * law.work_of_adhesion * law.reduced_modulus *
                              law.reduced_modulus / law.radius) *
             (s + law.m * law.m * elementary::atan(s));
  return law;
}

double contact_radius_slope(double depth) noexcept {
  return depth >= 0 && depth < kDeepest ? kRadiusPerDepth : 0;
}

AdhesionForce adhesion(const Adhesion& law, double depth) noexcept {
  constexpr double a0 = kInteratomicDistance;
  if (depth <= -a0) return {};

  // force(a) = stiff a^3 - pull a^2, and its integral over a
  const double stiff = law.reduced_modulus / law.radius;
  const double pull = law.pull;
  const auto force = [&](double a) { return a * a * (stiff * a - pull); };
  const auto integral = [&](double a) { return a * a * a * (stiff * a / 4 - pull / 3); };

  const double touch = force(kRadiusAtTouch);
  if (depth < 0) {
    const double t = 1 + depth / a0;  // 0 .. 1 over the last a_0 of the approach
    return {{0.5 * touch * a0 * t * t, touch * t, touch / a0}, 0, 0, 0};
  }
  const double a = contact_radius(depth);
  const double beyond = std::max(0.0, depth - kDeepest);
  const double potential = 0.5 * touch * a0 +
                           (integral(a) - integral(kRadiusAtTouch)) / kRadiusPerDepth +
                           force(a) * beyond;
  const double slope = beyond > 0 ? 0.0 : a * (3 * stiff * a - 2 * pull) * kRadiusPerDepth;
  return {{potential, force(a), slope}, a, contact_radius_slope(depth), 0};
}

}  // namespace ferrule::printed
