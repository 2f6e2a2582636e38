#include "sim/laws/gravity.hpp"

#include <numbers>

namespace ferrule {

double gravity(const Gravity& law, const FibreMass& fibre) noexcept {
  const double mass = fibre.density * std::numbers::pi * fibre.radius * fibre.radius * fibre.length;
  return law.form == Form::printed ? mass : mass * kStandardGravity;
}

}  // namespace ferrule
