// What a page replays: insertions that are over, frame by frame, with their events.
//
// As JSON {"mode": "replay", "title", "scene" (view/frame.hpp), "columns", "phases", "runs":
//   [{"name", "outcome", "why", "rows": as view/packed_rows.hpp has them, "count",
//     "events": [{"t_s", "row", "kind": contact|bridge|slip|jam|limit|seated|end, "text"}],
//     "scene" where it is not that of all}],
//   "over": place of the run to be laid over the first, where both began alike,
//   "maps": [{"title", "command", "points": [{"trial", "y_um", "z_um", "outcome",
//     "run": place in "runs", where it is there}]}]}
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "capture/episode.hpp"
#include "controller/trial.hpp"
#include "sim/base/control_period.hpp"
#include "view/frame.hpp"

namespace ferrule {

// In the order of time. `row` is the frame that shows it first.
struct ReplayEvent {
  std::size_t row;
  const char* kind;
  std::string text;
};

struct ReplayRun {
  std::string name;
  Outcome outcome = Outcome::interrupted;
  std::string why;  // one sentence: what ended it, where
  Json scene;       // scene_json of it
  std::vector<Frame> frames;
  std::vector<ReplayEvent> events;
};

// `scene`: recorded_scene of it.
ReplayRun replay_of(const Episode& episode, const Scene& scene, const std::string& run_name);
// Trial `trial` of a campaign under `seed`, made again; no frames where its parts do not fit.
ReplayRun replay_of(const Scene& scene, const MakeController& make, std::uint64_t seed,
                    std::uint64_t trial, const std::string& run_name,
                    double period = kControlPeriod);

// The trials of one campaign, by start and outcome. Each point may name a run.
struct TrialMap {
  std::string title, command;  // the command shows a trial, with TRIAL where its number goes
  std::vector<TrialResult> results;
  std::vector<Vector2d> starts;                  // y, z of each [m]
  std::vector<std::optional<std::size_t>> runs;  // as many as results
};

// Leaves `rate` frames a second, the last one, and all within 10 ms of an event.
void thin(ReplayRun& run, double rate);

// There is one run at least.
Json replay_json(const std::string& title, const std::vector<ReplayRun>& runs,
                 const std::vector<TrialMap>& maps = {});

}  // namespace ferrule
