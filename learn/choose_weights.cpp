#include "learn/choose_weights.hpp"

#include <algorithm>
#include <limits>
#include <mutex>

#include "controller/campaign.hpp"
#include "sim/base/random.hpp"
#include "sim/scene/scene.hpp"

namespace ferrule {

void add_member(Policy& policy, const Weights& weights) {
  policy.members.push_back(weights.network);
  if (weights.memory.units() > 0) policy.memories.push_back(weights.memory);
}

TriedWeights choose_weights(const std::vector<Snapshot>& snapshots, Policy policy,
                            const std::vector<Json>& scenes, std::size_t rollouts,
                            std::uint64_t seed, const std::function<bool()>& go_on) {
  // Those of a campaign with `seed` itself are never among them.
  const std::uint64_t trials_seed = RandomStream(seed, 0, "rollouts").bits() >> 1;
  std::vector<Scene> parsed;
  for (std::size_t k = 0; k < std::min(rollouts, scenes.size()); ++k)
    parsed.push_back(parse_scene(scenes[k], "a scene of the episodes"));
  std::mutex asking;
  const auto stop = [&] {
    const std::lock_guard lock(asking);
    return !go_on();
  };
  TriedWeights best;
  double least = std::numeric_limits<double>::infinity();
  for (const Snapshot& snapshot : snapshots) {
    policy.members.clear();
    policy.memories.clear();
    add_member(policy, snapshot.weights);
    std::size_t inserted = 0;
    double time = 0;
    for (std::size_t k = 0; k < parsed.size(); ++k)
      for (const TrialResult& trial : run_campaign(
               parsed[k], controller_maker(PolicyController(policy)), trials_seed,
               (rollouts + k) / parsed.size(), 0, [](std::size_t) {}, stop)) {
        inserted += trial.outcome == Outcome::inserted;
        time += trial.summary.time;
      }
    if (stop()) return {};
    if (best.tried && (inserted < best.inserted || (inserted == best.inserted && time >= least)))
      continue;
    best = {&snapshot, inserted};
    least = time;
  }
  return best;
}

}  // namespace ferrule
