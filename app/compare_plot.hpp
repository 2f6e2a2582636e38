// What `ferrule compare` finds, drawn.
#pragma once

#include "app/compared.hpp"
#include "app/plot.hpp"

namespace ferrule {

std::vector<Ring> by_misalignment(const std::vector<TrialResult>& results,
                                  const std::vector<Vector2d>& starts);

Plot misalignment_plot(const std::vector<Entry>& entries);
// Of several seeds the worst.
Plot learning_plot(const std::vector<LearnedAgain>& learning);
// On one rung of the ladder: success of each controller in tenths of the drawn number that decides
// it.
Plot rung_plot(const std::vector<LadderRow>& rung);
// The starts [m] of the trials of one controller, by whether it inserted.
Plot failure_map(const std::string& controller, const std::vector<TrialResult>& results,
                 const std::vector<Vector2d>& starts);

}  // namespace ferrule
