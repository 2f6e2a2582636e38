// Scenes and motions drawn at random over what a scene file allows, for measuring the worst.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim/scene/scene.hpp"

namespace ferrule {

// Scene `k` under `seed`: every law present or not, in either form where both exist, either holder,
// with or without lead-in, roughness and inertia; every number log-uniform, one in twenty over the
// whole range of the schema, else over what could be built (clearances from 20 nm to 50 um). Scenes
// that the parser refuses are drawn again.
Scene random_scene(std::uint64_t seed, std::uint64_t k);

// What a hand does from a start in free air, and back to where it began.
enum class Motion {
  insertion,  // in and out while it wanders sideways and in tilt, below the speed limit
  press,      // in, against the wall as hard as the force limit, along it, and out
  jumps,      // from place to place: by a nanometre up to hundreds of clearances in one step
};
inline constexpr int kMotions = 3;
const char* name(Motion motion) noexcept;

// The commands of one such motion, `period` [s] apart, in a world where the end rests at `start`:
// the last is the first. Finer periods sample the same motion; jumps go in straight lines over one
// millisecond. `longest` [s]: faster than the limit where the way is too long.
std::vector<Pose> commands(const Scene& scene, const State& start, Motion motion, double period,
                           std::uint64_t seed, std::uint64_t k, double longest = 20);

}  // namespace ferrule
