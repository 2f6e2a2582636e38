#include "sim/analysis/damage.hpp"

#include <cmath>
#include <limits>
#include <numbers>

namespace ferrule {

DamageForces damage_forces(const World& world, double reduced_modulus, double poisson,
                           double stress, double edge) noexcept {
  using std::numbers::pi;
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const double r = world.annulus.fibre_radius, length = world.holder.free_length;
  const bool elastic = length > 0;
  // E* = (3/4) K of equation (7).
  const double modulus = 0.75 * reduced_modulus;
  const double pressure = 3 * stress / (1 - 2 * poisson);
  const double push = pi * pressure;
  const double ring = push * push * push * edge * r / (6 * modulus * modulus);
  return {elastic ? world.holder.euler_load : kNever,
          elastic ? pi * r * r * r * stress / (4 * length) : kNever, ring, kEdgeToughness * edge};
}

}  // namespace ferrule
