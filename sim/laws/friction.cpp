#include "sim/laws/friction.hpp"

#include <cmath>

namespace ferrule {
namespace {

constexpr double kSmall = 50, kLarge = 1e5;                 // a_1, a_2 [-]
constexpr double kStressSmall = 0.02, kStressLarge = 8e-4;  // tau_f1, tau_f2 [-]

}  // namespace

double hurtado_kim_m() noexcept {
  return -std::log10(kStressSmall / kStressLarge) / std::log10(kLarge / kSmall);
}

double hurtado_kim_b() noexcept {
  return (std::log10(kStressSmall) * std::log10(kLarge) -
          std::log10(kStressLarge) * std::log10(kSmall)) /
         std::log10(kLarge / kSmall);
}

double friction(const Friction& law, double contact_radius) noexcept {
  static const double exponent = hurtado_kim_m() + 2, factor = std::pow(10.0, hurtado_kim_b());
  const double a = contact_radius / law.burgers;
  const double scale = law.effective_shear_modulus() * law.burgers * law.burgers;
  if (a < kSmall) return scale * kStressSmall * a * a;
  if (a > kLarge) return scale * kStressLarge * a * a;
  return scale * factor * std::pow(a, exponent);
}

double stuck_stiffness(const Friction& law, double contact_radius) noexcept {
  return 8 * law.effective_shear_modulus() * contact_radius;
}

}  // namespace ferrule
