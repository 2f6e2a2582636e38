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

// Trial `trial` of `scene` under `seed` with `device`, as episode `number` of `folder`. Throws
// FileTrouble.
Recorded record_one(const Scene& scene, const State& start, Device& device,
                    const std::string& operator_name, const std::string& folder, int number,
                    std::uint64_t seed, std::uint64_t trial);

}  // namespace ferrule
