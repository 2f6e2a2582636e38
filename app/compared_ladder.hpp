// compare --ladder: every controller on every rung of data/scenes/ladder.
#pragma once

#include "app/compared.hpp"

namespace ferrule {

// "ladder/a", ..., sorted.
std::vector<std::string> rungs();

// Of the entries and of what was learned by several seeds what is the same in every scene: what was
// given, and what was learned, of each seed where there are several.
std::vector<Compared> for_all_scenes(const std::vector<Entry>& entries,
                                     const std::vector<LearnedAgain>& by_seeds);

// The baselines, the blind spiral, and the others.
std::vector<LadderRow> climb(const CompareArguments& a, const Scene& rung,
                             const DemonstrationSet& set, const std::vector<Compared>& others);

}  // namespace ferrule
