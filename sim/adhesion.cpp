#include "sim/adhesion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/printed_range.hpp"

namespace ferrule {
namespace {

constexpr double kRadiusAtTouch = 100e-9;  // [m]
constexpr double kRadiusPerDepth = 2.0;    // 20 nm over 10 nm

AdhesionForce prescribed(const Adhesion& law, double depth) noexcept {
  constexpr double a0 = printed::kInteratomicDistance;
  if (depth <= -a0) return {};

  // force(a) = stiff a^3 - pull a^2, and its integral over a
  const double stiff = law.reduced_modulus / law.radius;
  const double s = std::sqrt((law.m - 1) * (law.m + 1));
  const double pull = law.maugis_lambda *
                      std::cbrt(std::numbers::pi * law.work_of_adhesion * law.reduced_modulus *
                                law.reduced_modulus / law.radius) *
                      (s + law.m * law.m * std::atan(s));
  const auto force = [&](double a) { return a * a * (stiff * a - pull); };
  const auto integral = [&](double a) { return a * a * a * (stiff * a / 4 - pull / 3); };

  const double touch = force(kRadiusAtTouch);
  if (depth < 0) {
    const double t = 1 + depth / a0;  // 0 .. 1 over the last a_0 of the approach
    return {{0.5 * touch * a0 * t * t, touch * t, touch / a0}, 0, 0};
  }
  const double a = printed_contact_radius(depth);
  const double beyond = std::max(0.0, depth - kPrintedDepth);
  const double potential = 0.5 * touch * a0 +
                           (integral(a) - integral(kRadiusAtTouch)) / kRadiusPerDepth +
                           force(a) * beyond;
  const double slope = beyond > 0 ? 0.0 : a * (3 * stiff * a - 2 * pull) * kRadiusPerDepth;
  return {{potential, force(a), slope}, a, 0};
}

}  // namespace

double reduced_modulus(double young_fibre, double poisson_fibre, double young_ferrule,
                       double poisson_ferrule) noexcept {
  return 4.0 / 3.0 /
         ((1 - poisson_fibre * poisson_fibre) / young_fibre +
          (1 - poisson_ferrule * poisson_ferrule) / young_ferrule);
}

double printed_contact_radius(double depth) noexcept {
  return kRadiusAtTouch + kRadiusPerDepth * std::clamp(depth, 0.0, kPrintedDepth);
}

double maugis_force_scale(const Adhesion& law) noexcept {
  return std::numbers::pi * law.work_of_adhesion * law.radius;
}
double maugis_depth_scale(const Adhesion& law) noexcept {
  const double f = std::numbers::pi * law.work_of_adhesion / law.reduced_modulus;
  return std::cbrt(f * f * law.radius);
}
double maugis_radius_scale(const Adhesion& law) noexcept {
  return std::cbrt(std::numbers::pi * law.work_of_adhesion * law.radius * law.radius /
                   law.reduced_modulus);
}

AdhesionForce adhesion(const Adhesion& law, double depth, int branch) noexcept {
  if (law.form == Form::printed) return prescribed(law, depth);
  const double force = maugis_force_scale(law), length = maugis_depth_scale(law);
  const MaugisCurve::Value value = law.curve->at(depth / length, branch);
  return {{force * length * value.energy, force * value.P, force / length * value.slope},
          maugis_radius_scale(law) * value.A,
          value.branch};
}

}  // namespace ferrule
