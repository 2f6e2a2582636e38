// What `ferrule compare` finds, drawn.
#pragma once

#include "app/plot.hpp"
#include "controller/worst_tenth.hpp"
#include "learn/candidates.hpp"

namespace ferrule {

// Trials whose starts are about as far from the axis: an eighth of all.
struct Ring {
  double from, to;  // distance of the start from the axis [m]
  std::size_t feasible, inserted;
};
std::vector<Ring> by_misalignment(const std::vector<TrialResult>& results,
                                  const std::vector<Vector2d>& starts);

// Success of a learner from the first `demonstrations` of what one seed recorded.
struct Learning {
  std::string name;
  std::uint64_t training_seed;
  std::size_t demonstrations, rollouts;
  CampaignSummary summary;
};

Plot misalignment_plot(const std::vector<std::pair<std::string, std::vector<Ring>>>& controllers);
// Of several seeds the worst.
Plot learning_plot(const std::vector<Learning>& learning);
// On a rung of the ladder: success of each controller in tenths of the drawn number that decides it.
Plot rung_plot(const std::string& rung,
               const std::vector<std::pair<std::string, Deciding>>& controllers);
// The starts [m] of the trials of one controller, by whether it inserted.
Plot failure_map(const std::string& controller, const std::vector<TrialResult>& results,
                 const std::vector<Vector2d>& starts);

}  // namespace ferrule
