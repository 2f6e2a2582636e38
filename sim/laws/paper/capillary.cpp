#include "sim/laws/paper/capillary.hpp"

#include "sim/base/elementary.hpp"
#include "sim/laws/paper/range.hpp"

namespace ferrule::printed {

LineForce capillary(const Capillary& law, double h) noexcept {
  const double cosine = elementary::cos(law.contact_angle);
  const double pull = 2 * law.surface_tension * cosine;
  const double meet = 2 * law.film;
  return down_to_contact(
      [&](double gap) noexcept -> LineForce {
        // 1 - (h - 2e) cos / h = (1 - cos) + 2 e cos / h
        return {pull * ((1 - cosine) * (gap - meet) + meet * cosine * elementary::log(gap / meet)),
                -pull * ((1 - cosine) + meet * cosine / gap), pull * meet * cosine / (gap * gap)};
      },
      h);
}

}  // namespace ferrule::printed
