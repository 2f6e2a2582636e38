// A simulated trainee set to a scene's task.
#pragma once

#include <cstdint>
#include <memory>

#include "haptic/trainee.hpp"
#include "sim/scene/scene.hpp"
#include "sim/state.hpp"

namespace ferrule {

// To push the fibre of `start` a tenth (2 um at least) deeper than the scene's success depth at the
// scene's speed limit.
TraineeTask trainee_task(const Scene& scene, const State& start, double period) noexcept;

// A trainee of `skill` (0 to 1) whose hand holds the fibre of `start`, with that task. Its chance
// is that of (seed, trial).
std::unique_ptr<Device> simulated_operator(const Scene& scene, const State& start, double skill,
                                           double period, std::uint64_t seed, std::uint64_t trial);

}  // namespace ferrule
