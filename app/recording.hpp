// Recording one episode into a folder: used by `record` and `demo`.
#pragma once

#include <string>

#include "capture/session.hpp"

namespace ferrule {

struct Recorded {
  std::string file;
  Outcome outcome;
  InsertionSummary summary;
};

// The first of trials trial, trial + 2^32, trial + 2 2^32 ... whose pair of parts fits.
struct FeasibleTrial {
  std::shared_ptr<const Scene> scene;
  std::uint64_t trial;
  std::size_t infeasible;  // pairs put aside
};
// Throws BadInput where hardly any pair fits.
FeasibleTrial feasible_trial(const Scene& scene, std::uint64_t seed, std::uint64_t trial);

// Trial `trial` of `scene` under `seed` with `device`, as episode `number` of `folder`. Throws
// FileTrouble.
Recorded record_one(const Scene& scene, const State& start, Device& device,
                    const std::string& operator_name, const std::string& folder, int number,
                    std::uint64_t seed, std::uint64_t trial);

}  // namespace ferrule
