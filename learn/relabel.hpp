// What a policy meets when it inserts by itself, with what the simulated operator would have done.
#pragma once

#include "controller/policy.hpp"
#include "insertion/operator_skill.hpp"
#include "learn/demonstrations.hpp"

namespace ferrule {

// Lets the policy insert in trial `trial` of `scene` under `seed` (or the next whose parts fit),
// until a tenth past the success depth or to its failure, and asks a simulated operator at every
// tick what he would do with his hand there, feeling that: his answer is what the demonstration
// demonstrates. He answers without tremor and hesitation, with the reaction time `reaction` [s].
Demonstration relabelled_trial(const Scene& scene, const Policy& policy,
                               const SimulatedOperator& teacher, double reaction,
                               std::uint64_t seed, std::uint64_t trial);

}  // namespace ferrule
