#include "sim/laws/paper/electrostatic.hpp"

#include "sim/laws/paper/range.hpp"

namespace ferrule::printed {
namespace {

constexpr double kPermittivityTableI = 8.85e-12;  // eps0 [F/m]

}  // namespace

LineForce electrostatic(const Electrostatic& law, const Annulus& annulus, double h) noexcept {
  const double strength =
      0.5 * kPermittivityTableI * law.voltage * law.voltage * annulus.fibre_radius * kPatchAngle;
  return down_to_contact(
      [&](double gap) noexcept -> LineForce {
        return {-strength / gap, -strength / (gap * gap), 2 * strength / (gap * gap * gap)};
      },
      h);
}

}  // namespace ferrule::printed
