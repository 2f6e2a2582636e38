// A simulated trainee set to a scene's task.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "haptic/trainee.hpp"
#include "sim/model/state.hpp"
#include "sim/scene/scene.hpp"

namespace ferrule {

// To push the fibre of `start` a tenth (2 um at least) deeper than the scene's success depth, from
// where the entrance is taken to be, at the scene's speed limit; and where the scene lets him see
// the bore's axis, to steer the end there before the entrance, as well as he sees it in
// (seed, trial).
TraineeTask trainee_task(const Scene& scene, const State& start, double period, std::uint64_t seed,
                         std::uint64_t trial) noexcept;

// A trainee of `skill` (0 to 1) whose hand holds the fibre of `start`, with that task. Its chance
// is that of (seed, trial).
std::unique_ptr<Device> simulated_operator(const Scene& scene, const State& start, double skill,
                                           double period, std::uint64_t seed, std::uint64_t trial);

// The same of trial `trial`, in the scene and at the start that are drawn for it.
std::unique_ptr<Device> operator_of_trial(const Scene& scene, double skill, double period,
                                          std::uint64_t seed, std::uint64_t trial);

// What a recording calls its operator where he is simulated: "simulated, skill 0.8"; and the skill
// of an operator of that name, empty for any other.
std::string simulated_operator_name(double skill);
std::optional<double> simulated_skill(const std::string& name);
// The same of other simulated operators: "WHO, skill 0.8".
std::string operator_name(const std::string& who, double skill);
std::optional<double> skill_of(const std::string& who, const std::string& name);

}  // namespace ferrule
