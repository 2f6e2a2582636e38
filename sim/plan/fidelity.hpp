// How exactly a world computes its terms, in words and in numbers.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "sim/surface_forces.hpp"

namespace ferrule {

// How `term`, a place in kTermNames that the world has, is computed.
std::string fidelity(const World& world, int term);

// Largest force in a surface term that `coarse` gets wrong at these poses, by term [N].
std::array<double, kSurfaceTerms> fidelity_error(const World& coarse, const World& full,
                                                 const std::vector<State>& states);

}  // namespace ferrule
