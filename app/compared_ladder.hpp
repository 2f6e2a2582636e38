// compare --ladder: every controller on every rung of data/scenes/ladder.
#pragma once

#include "app/compared.hpp"

namespace ferrule {

// "ladder/a", ..., sorted.
std::vector<std::string> rungs();

// Those of `candidates` from `first` on that were given, and those that learned: of each seed of
// training where there are several.
std::vector<Climber> climbers(const CompareArguments& a, const std::vector<Candidate>& candidates,
                              std::size_t first, const std::vector<BySeed>& by_seeds);

// The baselines, the blind spiral, and the others.
std::vector<LadderRow> climb(const CompareArguments& a, const Scene& rung,
                             const DemonstrationSet& set, const std::vector<Climber>& others);

}  // namespace ferrule
