// Which weights of a training are kept: by rollouts.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "controller/policy.hpp"
#include "learn/torch_policy.hpp"
#include "sim/base/json_fields.hpp"

namespace ferrule {

// As the last of its members.
void add_member(Policy& policy, const Weights& weights);

struct TriedWeights {
  const Snapshot* tried = nullptr;  // none where it was stopped
  std::size_t inserted = 0;         // of `rollouts`
};

// Lets a policy with each of these weights insert in the same `rollouts` trials under a seed made
// of `seed`, in turn in the scenes of these documents (one at least), on all cores. The result is
// the one that inserts most often, and of those that insert as often the one that takes least time.
// `policy` gives all but the members. `go_on` is asked often, from any thread, one at a time; false
// ends it.
TriedWeights choose_weights(const std::vector<Snapshot>& snapshots, Policy policy,
                            const std::vector<Json>& scenes, std::size_t rollouts,
                            std::uint64_t seed, const std::function<bool()>& go_on);

}  // namespace ferrule
