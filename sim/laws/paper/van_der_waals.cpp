#include "sim/laws/paper/van_der_waals.hpp"

#include <numbers>

#include "sim/laws/paper/range.hpp"

namespace ferrule::printed {
namespace {

constexpr double kRange = 100e-9;  // [m], "h <= 100 nm"
constexpr double kTaper = 1e-9;    // [m]

}  // namespace

LineForce van_der_waals(const VanDerWaals& law, const Annulus& annulus, double h) noexcept {
  if (h >= kRange + kTaper) return {};
  const double strength =
      law.hamaker * annulus.fibre_radius * kPatchAngle / (24.0 * std::numbers::pi);
  const double end_force = -strength / (kRange * kRange * kRange);
  if (h >= kRange) {
    // force = end_force (1 - 3 t^2 + 2 t^3) over the taper, t in [0, 1]
    const double t = (h - kRange) / kTaper;
    const double area_left = 0.5 - t + t * t * t - 0.5 * t * t * t * t;
    return {end_force * kTaper * area_left, end_force * (1 - t * t * (3 - 2 * t)),
            end_force * 6 * t * (t - 1) / kTaper};
  }
  const double end_potential = 0.5 * end_force * kTaper;
  return down_to_contact(
      [&](double gap) noexcept -> LineForce {
        const double g2 = gap * gap;
        return {end_potential - 0.5 * strength * (1 / g2 - 1 / (kRange * kRange)),
                -strength / (g2 * gap), 3 * strength / (g2 * g2)};
      },
      h);
}

}  // namespace ferrule::printed
