// compare --ladder: every controller on every rung of data/scenes/ladder.
#include "app/compared_ladder.hpp"

#include "app/compared_learners.hpp"
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

std::vector<Compared> for_all_scenes(const std::vector<Entry>& entries,
                                     const std::vector<LearnedAgain>& by_seeds) {
  std::vector<Compared> all;
  for (const Entry& e : entries)
    if (!e.of_scene && (!e.fit || by_seeds.empty())) all.push_back(e);
  all.insert(all.end(), by_seeds.begin(), by_seeds.end());
  return all;
}

std::vector<LadderRow> climb(const CompareArguments& a, const Scene& rung,
                             const DemonstrationSet& set, const std::vector<Compared>& others) {
  std::vector<Compared> all = without_learning(a, rung, set);
  all.push_back({{.name = "blind spiral", .make = baseline(kSpiral, rung, a.seed)}});
  all.insert(all.end(), others.begin(), others.end());
  const std::vector<DrawnQuantity> drawn =
      drawn_quantities(rung, a.seed, a.job->runs_a_shard() ? 0 : a.trials);
  std::vector<LadderRow> rows;
  for (const Compared& c : all) {
    const auto trials = [&](const MakeController& make, const std::string& what) {
      return run_campaign(rung, make, a.seed, a.trials, a.threads, Progress(what, a.trials),
                          interrupted, {}, a.job->store.get());
    };
    const std::string what = rung.name + ", " + c.name;
    const auto results = trials(c.make, what);
    std::optional<CampaignSummary> kept;
    if (a.supervise)
      kept = summarise(trials(supervised(c.make, supervisor_limits(rung)), what + ", supervised"));
    if (interrupted()) break;  // of it, the trials are not whole
    rows.push_back({rung.name, c.name, c.without, training_seed(c), summarise(results), kept,
                    worst_tenth(drawn, results), median_search_time(results),
                    deciding_quantity(drawn, results)});
  }
  return rows;
}

}  // namespace ferrule
