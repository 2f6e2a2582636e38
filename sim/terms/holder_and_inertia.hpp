// Holder, weight and inertia, and sideways drag: what is quadratic in the pose over a step
// (FrozenCoefficients::stiffness and load).
#pragma once

#include "sim/terms/potential.hpp"

namespace ferrule {

// Reports the holder's wrench and the weight.
struct HolderTerm {
  static void add(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                  Energy& total) noexcept;
  static void report(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                     const Potential& potential, Breakdown& b) noexcept;
};

}  // namespace ferrule
