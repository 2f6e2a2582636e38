// Surface forces of a step (sim/terms/surface_forces.hpp): in the round bore that an oval one is
// stretched to, and from where the fibre is whole around.
#pragma once

#include "sim/terms/potential.hpp"

namespace ferrule {

// `tip` in that bore, moved to where the fibre is whole around.
PoseVector whole(const World& world, const PoseVector& tip) noexcept;

// Adds to the bore's energy, and to Potential::surface.
struct SurfaceForcesTerm {
  static void add(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                  Potential& potential) noexcept;
  static void report(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                     const Potential& potential, Breakdown& b) noexcept;
};

}  // namespace ferrule
