// What chance decides about a trial: the numbers of its scene, and where its fibre starts.
#pragma once

#include <cstdint>
#include <memory>

#include "sim/scene/scene.hpp"

namespace ferrule {

// The scene of trial `trial` under `seed`, with the numbers that chance decides (Scene::drawn) and
// its particle, where there is one; null where such parts cannot be together: the fibre is wider
// than the bore, say. `scene` itself, which it must not outlive, where nothing is drawn. What is
// named `redrawn` is drawn as under another seed (seed_of).
std::shared_ptr<const Scene> draw_scene(const Scene& scene, std::uint64_t seed, std::uint64_t trial,
                                        const std::string& redrawn = "");

// The first of trials trial, trial + 2^32, trial + 2 2^32 ... whose parts can be together.
struct FeasibleTrial {
  std::shared_ptr<const Scene> scene;
  std::uint64_t trial;
  std::size_t infeasible;  // trials put aside
};
// Throws BadInput where hardly any can.
FeasibleTrial feasible_trial(const Scene& scene, std::uint64_t seed, std::uint64_t trial);

// The end at rest, held where it would be at `tip` in free air [m, rad]. With inertia an end that
// would begin in a wall leans on it, or its inertia would fling it out; without, the first step
// finds that pose.
State start_at(const World& world, const Pose& tip) noexcept;

// Start of trial `trial` under `seed`: the fibre as start_at leaves it, misaligned as the scene says,
// and with it the same whether `scene` was drawn or not.
State draw_start(const Scene& scene, std::uint64_t seed, std::uint64_t trial);

}  // namespace ferrule
