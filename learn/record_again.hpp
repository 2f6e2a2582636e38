// The same demonstrations by chance anew: what another recording seed would have given.
#pragma once

#include "insertion/operator_skill.hpp"
#include "learn/demonstrations.hpp"

namespace ferrule {

// Throws BadInput where the operators were not all simulated, or the episodes are of several
// scenes.
void expect_recordable_again(const DemonstrationSet& set);

// As many episodes as `set` was made of, by simulated operators of the same skills, in the same
// scene with trials 1, 2, ... under `seed`, in memory. Throws as expect_recordable_again; and what
// `go_on` throws, called before each episode.
DemonstrationSet record_again(const DemonstrationSet& set, std::uint64_t seed,
                              const std::function<void()>& go_on = {});

// `count` episodes of a simulated operator of `skill` in `scene`, trials 1, 2, ... under `seed`, in
// memory.
DemonstrationSet simulated_demonstrations(const Scene& scene, const OperatorSkill& skill,
                                          std::uint64_t seed, std::size_t count);

}  // namespace ferrule
