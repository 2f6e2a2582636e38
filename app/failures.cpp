#include "app/failures.hpp"

#include <fmt/format.h>

#include "app/html.hpp"
#include "sim/scene/draw.hpp"
#include "view/page_file.hpp"

namespace ferrule {
namespace {

constexpr double kReportRate = 30;  // frames a second of them

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
                  std::size_t most, std::vector<ReplayRun>& runs, std::vector<TrialMap>& maps) {
  const std::vector<TrialResult>& results = *tested.results;
  TrialMap map{tested.name, tested.command, results, {}, {}};
  map.runs.resize(results.size());
  for (std::size_t k = 0; k < results.size(); ++k)
    map.starts.push_back(draw_start(scene, seed, k).tip.segment<2>(1));
  for (const std::size_t k : shown_failures(results, most)) {
    map.runs[k] = runs.size();
    runs.push_back(
        replay_of(scene, tested.make, seed, k, fmt::format("{}, trial {}", tested.name, k)));
    thin(runs.back(), kReportRate);
  }
  maps.push_back(std::move(map));
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
