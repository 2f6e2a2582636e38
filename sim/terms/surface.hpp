// Surface forces of a step (sim/terms/surface_forces.hpp): in the round bore that an oval one is
// stretched to, and from where the fibre is whole around.
#pragma once

#include "sim/terms/potential.hpp"

namespace ferrule {

// `tip` in that bore, moved to where the fibre is whole around.
PoseVector whole(const World& world, const PoseVector& tip) noexcept;

// From the end to where the printed laws act, in the middle of their length; 0 without any [m]. And
// the gap there; infinite without any [m].
double printed_arm(const World& world, const FrozenCoefficients& frozen) noexcept;
double printed_gap(const World& world, const FrozenCoefficients& frozen,
                   const PoseVector& tip) noexcept;

// The length that they act along [m].
double printed_length(const World& world, const FrozenCoefficients& frozen) noexcept;

// Adds to the bore's energy, and to Potential::surface.
struct SurfaceForcesTerm {
  static void add(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                  Potential& potential) noexcept;
  static void report(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                     const Potential& potential, Breakdown& b) noexcept;
};

}  // namespace ferrule
