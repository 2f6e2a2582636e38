// A simulated trainee set to a scene's task.
#pragma once

#include <cstdint>
#include <memory>

#include "insertion/operator_skill.hpp"
#include "sim/model/state.hpp"
#include "sim/scene/scene.hpp"

namespace ferrule {

// To push the fibre of `start` a tenth (2 um at least) deeper than the scene's success depth, from
// where the entrance is taken to be, at the scene's speed limit; and where the scene lets him see
// the bore's axis, to steer the end there before the entrance, to where he sees it.
TraineeTask trainee_task(const Scene& scene, const State& start, double period) noexcept;

// A trainee of `skill` whose hand holds the fibre of `start`, with that task. Its chance
// is that of (seed, trial).
std::unique_ptr<Device> simulated_operator(const Scene& scene, const State& start,
                                           const OperatorSkill& skill, double period,
                                           std::uint64_t seed, std::uint64_t trial);

// The same of trial `trial`, in the scene and at the start that are drawn for it.
std::unique_ptr<Device> operator_of_trial(const Scene& scene, const OperatorSkill& skill,
                                          double period, std::uint64_t seed, std::uint64_t trial);

}  // namespace ferrule
