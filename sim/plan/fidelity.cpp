#include "sim/plan/fidelity.hpp"

#include <algorithm>

namespace ferrule {

std::array<double, kSurfaceTerms> fidelity_error(const World& coarse, const World& full,
                                                 const std::vector<State>& states) {
  std::array<double, kSurfaceTerms> worst{};
  for (const State& s : states) {
    std::array<SurfaceGradients, 2> terms;
    Energy energy;
    add_surface_forces(energy, terms[0], coarse, s.inserted_length(), s.bridge, s.tip);
    add_surface_forces(energy, terms[1], full, s.inserted_length(), s.bridge, s.tip);
    for (std::size_t i = 0; i < kSurfaceTerms; ++i) {
      const PoseVector &a = terms[0][i], &b = terms[1][i];
      // A wrong moment counts as a wrong force at the lever of the inserted length.
      const double lever = s.inserted_length() + coarse.annulus.fibre_radius;
      worst[i] = std::max(worst[i], PoseVector(a.x - b.x, a.e - b.e, a.t - b.t).length() +
                                        (a.t - b.t).norm() / lever);
    }
  }
  return worst;
}

}  // namespace ferrule
