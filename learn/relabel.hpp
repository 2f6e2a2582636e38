// What a policy meets when it inserts by itself, with what the simulated operator would have done.
#pragma once

#include "controller/policy.hpp"
#include "learn/demonstrations.hpp"

namespace ferrule {

// Lets the policy insert in trial `trial` of `scene` under `seed` (or the next whose parts fit),
// until a tenth past the success depth or to its failure, and asks a simulated operator of `skill`
// at every tick what it would do with its hand there, feeling that: its answer is the
// demonstration's velocity. It answers without tremor and hesitation, with the reaction time
// `reaction` [s].
Demonstration relabelled_trial(const Scene& scene, const Policy& policy, double skill,
                               double reaction, std::uint64_t seed, std::uint64_t trial);

}  // namespace ferrule
