// The trials of campaigns for a page: where they started, how they ended, those that failed, and
// which force acted when.
#pragma once

#include <string>
#include <vector>

#include "app/force_history_table.hpp"
#include "view/recorded.hpp"

namespace ferrule {

// A controller, and what it did in all trials under `seed`.
struct TestedController {
  std::string name, command;  // the command shows a trial, with TRIAL where its number goes
  MakeController make;
  const std::vector<TrialResult>* results;
};

// Adds its map to `maps`, and to `runs` the trials that failed, made again: all of them, up to a
// thousand in one report; of more than that some of every outcome.
void add_failures(const Scene& scene, std::uint64_t seed, const TestedController& tested,
                  std::vector<ReplayRun>& runs, std::vector<TrialMap>& maps);

// Which force acted when in its first trials, twenty at most, made again.
NamedHistory forces_of_trials(const Scene& scene, std::uint64_t seed,
                              const TestedController& tested);

// The beginning of a page with a replay_section (html_head).
std::string replay_head(const std::string& title);
// A replay within a report: HTML with all that it needs, or where the page of the window was not
// built what is missing. `title` is what it shows. Throws FileTrouble.
std::string replay_section(const std::string& title, const std::vector<ReplayRun>& runs,
                           const std::vector<TrialMap>& maps);

}  // namespace ferrule
