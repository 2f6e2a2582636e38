#include "sim/laws/wall.hpp"

#include <cmath>

namespace ferrule {

ContactForce wall(const Wall& law, double depth) noexcept {
  const double d = depth - law.begins;
  if (!(d > 0)) return {};
  const double root = std::sqrt(d * law.radius);
  const double force = law.reduced_modulus * root * d;
  return {0.4 * force * d, force, 1.5 * law.reduced_modulus * root};
}

}  // namespace ferrule
