// What chance decides about a trial: its pair of parts, and where its fibre starts.
#pragma once

#include <cstdint>
#include <memory>

#include "sim/scene/scene.hpp"

namespace ferrule {

// The scene of trial `trial` under `seed`: `scene` itself, or where chance decides about its parts
// (toleranced diameters, the roll angle of a curled or cleaved fibre, a particle, concentricity) or about where
// the entrance is taken to be, one with what was drawn; null where that pair interferes. It must
// not outlive `scene`. Throws BadInput if the scene cannot be with these diameters.
std::shared_ptr<const Scene> draw_scene(const Scene& scene, std::uint64_t seed,
                                        std::uint64_t trial);

// The first of trials trial, trial + 2^32, trial + 2 2^32 ... whose pair of parts fits.
struct FeasibleTrial {
  std::shared_ptr<const Scene> scene;
  std::uint64_t trial;
  std::size_t infeasible;  // pairs put aside
};
// As draw_scene. Throws BadInput where hardly any pair fits.
FeasibleTrial feasible_trial(const Scene& scene, std::uint64_t seed, std::uint64_t trial);

// The document of the scene that a drawn one was drawn from; of any other scene, `document` itself.
Json undrawn(Json document);

// Start of trial `trial` under `seed`: the fibre at rest, misaligned as the scene says, and with it
// the same whether `scene` was drawn or not. With inertia an end that would begin in the lead-in's
// wall leans on it.
State draw_start(const Scene& scene, std::uint64_t seed, std::uint64_t trial) noexcept;

}  // namespace ferrule
