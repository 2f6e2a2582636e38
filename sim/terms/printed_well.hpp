// The wells of the printed laws. Their surface forces grow towards the wall down to a gap of a_0
// (0.1 nm) and act at one place, in the middle of the inserted length. What falls in is held by up
// to 1e12 N/m in a well a tenth of a nanometre wide, and slides along the wall in it. What the
// solver does for that is here. Corrected laws have no such wells.
#pragma once

#include "sim/terms/potential.hpp"

namespace ferrule {

// The length that the printed surface forces act along [m].
double printed_length(const World& world, const FrozenCoefficients& frozen) noexcept;

// From the end to where they act, in the middle of that length; 0 without any [m].
double printed_arm(const World& world, const FrozenCoefficients& frozen) noexcept;

// The gap there; infinite without any [m].
double printed_gap(const World& world, const FrozenCoefficients& frozen,
                   const PoseVector& tip) noexcept;

// Is `tip`, at which the contacts have these depths, less than `distance` [m] from a well, of
// surface forces or of the adhesion? The forces turn within less than the clearance there.
bool near_printed_well(const World& world, const FrozenCoefficients& frozen,
                       const std::array<ContactDepth, kContactPlaces>& depth, const PoseVector& tip,
                       double distance) noexcept;

// Whether `tip` is in the well of the surface forces.
bool in_printed_well(const World& world, const FrozenCoefficients& frozen,
                     const PoseVector& tip) noexcept;

// `end`, where a move from `tip` in that well ends, with the gap that the middle of the length
// would have to first order: the axis turns about where the fibre is nearest to the wall, its end
// or the mouth.
PoseVector keep_in_printed_well(const World& world, const FrozenCoefficients& frozen,
                                const PoseVector& tip, const PoseVector& move,
                                const PoseVector& end) noexcept;

}  // namespace ferrule
