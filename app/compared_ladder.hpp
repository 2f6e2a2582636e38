// compare --ladder: every controller on every rung of data/scenes/ladder.
#pragma once

#include "app/compared.hpp"

namespace ferrule {

// "ladder/a", ..., sorted.
std::vector<std::string> rungs();

// The baselines, the blind spiral, what was given, and what learned: of each seed of training where
// there are several.
std::vector<LadderRow> climb(const CompareArguments& a, const Scene& rung,
                             const DemonstrationSet& set, const std::vector<Candidate>& candidates,
                             const std::vector<BySeed>& by_seeds);

}  // namespace ferrule
