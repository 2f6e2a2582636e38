// How exactly a world computes its surface forces.
#pragma once

#include <array>
#include <vector>

#include "sim/terms/surface_forces.hpp"

namespace ferrule {

// The surface forces of a world at each of these poses.
std::vector<SurfaceGradients> surface_gradients(const World& world,
                                                const std::vector<State>& states);

// Largest force in a surface term that `coarse` gets wrong at these poses, by term [N]; `full` are
// the right ones. Where the sum of all is above `enough` [N], no more poses are looked at.
std::array<double, kSurfaceTerms> fidelity_error(const World& coarse,
                                                 const std::vector<State>& states,
                                                 const std::vector<SurfaceGradients>& full,
                                                 double enough);

}  // namespace ferrule
