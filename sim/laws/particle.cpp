#include "sim/laws/particle.hpp"

#include <algorithm>

#include "sim/base/elementary.hpp"

namespace ferrule {

double unusual_height(const Particle& law) noexcept {
  constexpr double kOneIn = 50;
  if (!std::isnan(law.height)) return law.height;
  if (law.number == 0) return 0;
  const double z = std::sqrt(std::max(0.0, 2 * elementary::log(0.5 * kOneIn * law.number)));
  return std::min(law.median * elementary::exp(law.spread * z), kHighestParticle);
}

double shallowest(double height, double edge, double tangent) noexcept {
  const double wide = height + edge, foot = std::sqrt(2 * height * wide);
  return wide * tangent > foot ? 0.5 * wide * tangent + height / tangent : foot;
}

}  // namespace ferrule
