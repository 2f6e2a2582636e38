// A particle on the wall of the bore (sim/terms/particle_depth.hpp).
#pragma once

#include "sim/terms/potential.hpp"

namespace ferrule {

bool particle_acts(const World& world, const FrozenCoefficients& frozen) noexcept;

// Adds to the bore's energy.
struct ParticleTerm {
  static void add(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                  Potential& potential) noexcept;
  static void report(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                     const Potential& potential, Breakdown& b) noexcept;
};

}  // namespace ferrule
