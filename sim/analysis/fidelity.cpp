#include "sim/analysis/fidelity.hpp"

#include <algorithm>
#include <numeric>

namespace ferrule {
namespace {

SurfaceGradients gradients_at(const World& world, const State& s) {
  Energy energy;
  SurfaceGradients terms;
  add_surface_forces(energy, terms, world, s.inserted_length(), s.bridge, s.tip);
  return terms;
}

}  // namespace

std::vector<SurfaceGradients> surface_gradients(const World& world,
                                                const std::vector<State>& states) {
  std::vector<SurfaceGradients> all;
  for (const State& s : states) all.push_back(gradients_at(world, s));
  return all;
}

std::array<double, kSurfaceTerms> fidelity_error(const World& coarse,
                                                 const std::vector<State>& states,
                                                 const std::vector<SurfaceGradients>& full,
                                                 double enough) {
  std::array<double, kSurfaceTerms> worst{};
  for (std::size_t n = 0; n < states.size(); ++n) {
    const SurfaceGradients terms = gradients_at(coarse, states[n]);
    // A wrong moment counts as a wrong force at the lever of the inserted length.
    const double lever = states[n].inserted_length() + coarse.annulus.fibre_radius;
    for (std::size_t i = 0; i < kSurfaceTerms; ++i) {
      const PoseVector &a = terms[i], &b = full[n][i];
      worst[i] = std::max(worst[i], PoseVector(a.x - b.x, a.e - b.e, a.t - b.t).length() +
                                        (a.t - b.t).norm() / lever);
    }
    if (std::accumulate(worst.begin(), worst.end(), 0.0) > enough) break;
  }
  return worst;
}

}  // namespace ferrule
