// The trials of campaigns for a page: where they started, how they ended, and some that failed.
#pragma once

#include <string>
#include <vector>

#include "view/recorded.hpp"

namespace ferrule {

// A controller, and what it did in all trials under `seed`.
struct TestedController {
  std::string name, command;  // the command shows a trial, with TRIAL where its number goes
  MakeController make;
  const std::vector<TrialResult>* results;
};

// Adds its map to `maps`, and to `runs` up to `most` of the trials that failed, of every outcome,
// made again.
void add_failures(const Scene& scene, std::uint64_t seed, const TestedController& tested,
                  std::size_t most, std::vector<ReplayRun>& runs, std::vector<TrialMap>& maps);

// A replay within a report: HTML with all that it needs, or where the page of the window was not
// built what is missing. `title` is what it shows. Throws FileTrouble.
std::string replay_section(const std::string& title, const std::vector<ReplayRun>& runs,
                           const std::vector<TrialMap>& maps);

}  // namespace ferrule
