// What a liquid or gas does to the end as it moves: the pull of its meniscus, drag along and across
// the bore, and the flow of what is ahead of the end.
#pragma once

#include "sim/terms/potential.hpp"

namespace ferrule {

// Adds to the bore's energy.
struct MeniscusTerm {
  static void add(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                  Potential& potential) noexcept;
  static void report(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                     const Potential& potential, Breakdown& b) noexcept;
};

// Along the bore; across it HolderTerm has it.
struct DragTerm {
  static void add(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                  Energy& total) noexcept;
  static void report(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                     const Potential& potential, Breakdown& b) noexcept;
};

struct FlowTerm {
  static void add(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                  Energy& total) noexcept;
  static void report(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                     const Potential& potential, Breakdown& b) noexcept;
};

}  // namespace ferrule
