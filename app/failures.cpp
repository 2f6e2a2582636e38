#include "app/failures.hpp"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <atomic>

#include "app/html.hpp"
#include "app/interrupt.hpp"
#include "app/progress.hpp"
#include "sim/base/control_period.hpp"
#include "sim/scene/draw.hpp"
#include "view/page_file.hpp"

namespace ferrule {
namespace {

constexpr double kReportRate = 30;  // frames a second of them
// In one report, some five megabytes; but of a controller these at least.
constexpr std::size_t kMostShown = 1000, kShownOfEach = 50;
constexpr std::size_t kShownAtOnce = 24;  // where the user is in a hurry
constexpr std::size_t kForceTrials = 20;

// The failed trials to be shown: of every outcome in turn.
std::vector<std::size_t> shown_failures(const std::vector<TrialResult>& results, std::size_t most) {
  std::array<std::vector<std::size_t>, kOutcomes> by_outcome;
  for (std::size_t k = 0; k < results.size(); ++k) {
    const Outcome outcome = results[k].outcome;
    if (outcome != Outcome::inserted && outcome != Outcome::infeasible)
      by_outcome[static_cast<std::size_t>(outcome)].push_back(k);
  }
  std::vector<std::size_t> trials;
  for (std::size_t turn = 0; turn < most; ++turn)
    for (const auto& of_outcome : by_outcome)
      if (turn < of_outcome.size() && trials.size() < most) trials.push_back(of_outcome[turn]);
  std::sort(trials.begin(), trials.end());
  return trials;
}

}  // namespace

void add_failures(const Scene& scene, std::uint64_t seed, const TestedController& tested,
                  std::vector<ReplayRun>& runs, std::vector<TrialMap>& maps) {
  const std::vector<TrialResult>& results = *tested.results;
  TrialMap map{tested.name, tested.command, results, {}, {}};
  map.runs.resize(results.size());
  for (std::size_t k = 0; k < results.size(); ++k)
    map.starts.push_back(draw_start(scene, seed, k).tip.segment<2>(1));
  const std::vector<std::size_t> shown = shown_failures(
      results, std::max(kMostShown - std::min(kMostShown, runs.size()), kShownOfEach));
  std::vector<ReplayRun> again(shown.size());
  Progress progress("failed trials again", shown.size());
  std::atomic<std::size_t> done = 0;
  tbb::parallel_for(std::size_t{0}, shown.size(), [&](std::size_t i) {
    if (interrupted() && i >= kShownAtOnce) return;
    const std::string name = fmt::format("{}, trial {}", tested.name, shown[i]);
    again[i] = replay_of(scene, tested.make, seed, shown[i], name);
    thin(again[i], kReportRate);
    progress(++done);
  });
  for (std::size_t i = 0; i < shown.size(); ++i) {
    if (again[i].frames.empty()) continue;
    map.runs[shown[i]] = runs.size();
    runs.push_back(std::move(again[i]));
  }
  maps.push_back(std::move(map));
}

NamedHistory forces_of_trials(const Scene& scene, std::uint64_t seed,
                              const TestedController& tested) {
  const std::size_t trials = std::min(tested.results->size(), kForceTrials);
  std::vector<InsertionForces> forces(std::max<std::size_t>(trials, 1), InsertionForces(scene));
  tbb::parallel_for(std::size_t{0}, trials, [&](std::size_t k) {
    if (interrupted()) return;
    const auto controller = tested.make(k);
    run_trial(scene, *controller, seed, k, kControlPeriod, [&](const Tick& tick) {
      forces[k].add(make_row(tick));
      return true;
    });
  });
  const ForceHistory history = force_history(std::move(forces));
  return {fmt::format("{}, {} trial{}", tested.name, history.insertions,
                      history.insertions == 1 ? "" : "s"),
          history};
}

std::string replay_head(const std::string& title) {
  return html_head(title, built_page().value_or(""));
}

std::string replay_section(const std::string& title, const std::vector<ReplayRun>& runs,
                           const std::vector<TrialMap>& maps) {
  const std::optional<std::string> page = built_page();
  if (!page) return "<p>No animated replay: " + escaped(kNoPage) + ".</p>\n";
  if (runs.empty()) return "";
  return "<iframe class=replay sandbox=\"allow-scripts\" title=\"" + escaped(title) +
         "\" srcdoc=\"" + escaped(self_contained(*page, replay_json(title, runs, maps))) +
         "\"></iframe>\n";
}

}  // namespace ferrule
