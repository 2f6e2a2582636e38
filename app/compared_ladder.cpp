// compare --ladder: every controller on every rung of data/scenes/ladder.
#include "app/compared_ladder.hpp"

#include <cmath>

#include "app/interrupt.hpp"
#include "app/progress.hpp"
#include "app/shards.hpp"
#include "controller/supervisor.hpp"
#include "sim/base/shipped_files.hpp"

namespace ferrule {
namespace {

constexpr ShippedFiles kRungs = {"scenes/ladder", "scene file", "rung"};

double median_search_time(const std::vector<TrialResult>& results) {
  std::vector<double> times;
  for (const TrialResult& r : results)
    if (r.outcome == Outcome::inserted) times.push_back(r.summary.search_time());
  return quantile(times, 0.5);
}

}  // namespace

std::vector<std::string> rungs() {
  std::vector<std::string> all = kRungs.names();
  for (std::string& name : all) name = "ladder/" + name;
  return all;
}

std::vector<Climber> climbers(const CompareArguments& a, const std::vector<Candidate>& candidates,
                              std::size_t first, const std::vector<BySeed>& by_seeds) {
  std::vector<Climber> all;
  for (std::size_t i = first; i < candidates.size(); ++i) {
    const bool learned = candidates[i].parameters > 0 && std::isfinite(candidates[i].fit_seconds);
    if (!learned) all.push_back({candidates[i]});
    if (learned && by_seeds.empty()) all.push_back({candidates[i], a.fit_seed});
  }
  for (const BySeed& each : by_seeds) all.push_back({each.candidate, each.seed});
  return all;
}

std::vector<LadderRow> climb(const CompareArguments& a, const Scene& rung,
                             const DemonstrationSet& set, const std::vector<Climber>& others) {
  std::vector<Climber> all;
  for (const Candidate& c : without_learning(a, rung, set)) all.push_back({c});
  all.push_back({{.name = "blind spiral", .make = baseline(kSpiral, rung, a.seed)}});
  all.insert(all.end(), others.begin(), others.end());
  const std::vector<DrawnQuantity> drawn =
      drawn_quantities(rung, a.seed, a.job->runs_a_shard() ? 0 : a.trials);
  std::vector<LadderRow> rows;
  for (const Climber& c : all) {
    const std::string& name = c.candidate.name;
    const auto trials = [&](const MakeController& make, const std::string& what) {
      return run_campaign(rung, make, a.seed, a.trials, a.threads, Progress(what, a.trials),
                          interrupted, {}, a.job->trials());
    };
    const std::string what = rung.name + ", " + name;
    const auto results = trials(c.candidate.make, what);
    std::optional<CampaignSummary> kept;
    if (a.supervise)
      kept = summarise(
          trials(supervised(c.candidate.make, supervisor_limits(rung)), what + ", supervised"));
    if (interrupted()) break;  // of it, the trials are not whole
    rows.push_back({rung.name, name, c.without, c.training_seed, summarise(results), kept,
                    worst_tenth(drawn, results), median_search_time(results),
                    deciding_quantity(drawn, results)});
  }
  return rows;
}

}  // namespace ferrule
