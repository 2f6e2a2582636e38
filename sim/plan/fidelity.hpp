// How exactly a world computes its surface forces.
#pragma once

#include <array>
#include <vector>

#include "sim/surface_forces.hpp"

namespace ferrule {

// Largest force in a surface term that `coarse` gets wrong at these poses, by term [N].
std::array<double, kSurfaceTerms> fidelity_error(const World& coarse, const World& full,
                                                 const std::vector<State>& states);

}  // namespace ferrule
