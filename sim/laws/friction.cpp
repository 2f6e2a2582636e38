#include "sim/laws/friction.hpp"

#include <numbers>

#include "sim/base/elementary.hpp"

namespace ferrule {
namespace {

constexpr double kSmall = 50, kLarge = 1e5;                 // a_1, a_2 [-]
constexpr double kStressSmall = 0.02, kStressLarge = 8e-4;  // tau_f1, tau_f2 [-]

}  // namespace

double hurtado_kim_m() noexcept {
  return -elementary::log(kStressSmall / kStressLarge) / elementary::log(kLarge / kSmall);
}

double hurtado_kim_b() noexcept {
  return (elementary::log(kStressSmall) * elementary::log(kLarge) -
          elementary::log(kStressLarge) * elementary::log(kSmall)) /
         (elementary::log(kLarge / kSmall) * std::numbers::ln10);
}

namespace {
const double kM = hurtado_kim_m();
}  // namespace

// In terms of a'/a_1, as 10^B = tau_1 a_1^-M.
double friction(const Friction& law, double contact_radius) noexcept {
  const double least = kSmall * law.burgers;
  const double a = contact_radius / least;
  const double square = law.effective_shear_modulus() * least * least * a * a;
  if (a < 1) return kStressSmall * square;
  if (a > kLarge / kSmall) return kStressLarge * square;
  return kStressSmall * square * elementary::exp(kM * elementary::log(a));
}

double friction_exponent(const Friction& law, double contact_radius) noexcept {
  const double a = contact_radius / (kSmall * law.burgers);
  return a < 1 || a > kLarge / kSmall ? 2 : kM + 2;
}

double sticking_stiffness(const Friction& law, double contact_radius) noexcept {
  return 8 * law.effective_shear_modulus() * contact_radius;
}

}  // namespace ferrule
