#include "bench/plans.hpp"

#include <algorithm>
#include <functional>

#include "controller/campaign.hpp"
#include "insertion/scene_scaling.hpp"
#include "learn/candidates.hpp"
#include "sim/base/measure.hpp"

namespace ferrule {
namespace {

constexpr double kTolerance = 0.01;
constexpr int kTurns = 3;

double seconds_of(const std::function<void()>& work) {
  const double before = thread_seconds();
  work();
  return thread_seconds() - before;
}

struct Campaign {
  std::vector<TrialResult> results;
  std::vector<double> us_per_simulated_s;  // of each turn
};

void run(const Scene& scene, std::uint64_t seed, std::size_t trials, Campaign& campaign) {
  const Scaling scaling = scene_scaling(scene);
  const MakeController make = controller_maker(tuned_by_hand(scaling.motion * scene.limits.speed));
  const double seconds =
      seconds_of([&] { campaign.results = run_campaign(scene, make, seed, trials, 1, {}); });
  double simulated = 0;
  for (const TrialResult& r : campaign.results) simulated += r.summary.time;
  campaign.us_per_simulated_s.push_back(1e6 * seconds / simulated);
}

PlanRow measured(const std::string& name, std::uint64_t seed, std::size_t trials) {
  const Scene scene = load_scene(name);
  PlanRow row{};
  row.scene = name;
  Plan plan;
  row.planning_s = seconds_of([&] { plan = make_plan(scene, kTolerance, {}, PlanFor::success); });
  row.error_bound = plan.error_bound;
  row.sampled_twice = plan.sampled_twice;
  const Scene planned = parse_scene(plan.document, name);
  Json document = scene.document();
  document["quadrature"] = 16;
  document["tangent"] = {{"tip_nm", 0}, {"force_uN", 0}};
  const Scene full = parse_scene(document, name);
  Campaign of_full, of_shipped, of_planned;
  for (int turn = 0; turn < kTurns; ++turn) {
    run(full, seed, trials, of_full);
    run(scene, seed, trials, of_shipped);
    run(planned, seed, trials, of_planned);
  }
  row.full_us_per_simulated_s = std::ranges::min(of_full.us_per_simulated_s);
  row.shipped_us_per_simulated_s = std::ranges::min(of_shipped.us_per_simulated_s);
  row.planned_us_per_simulated_s = std::ranges::min(of_planned.us_per_simulated_s);
  row.ratio = row.full_us_per_simulated_s / row.planned_us_per_simulated_s;
  const CampaignSummary a = summarise(of_full.results), b = summarise(of_planned.results);
  row.trials = a.feasible;
  row.full_inserted = a.successes;
  row.full_interval = a.wilson;
  row.planned_inserted = b.successes;
  row.planned_interval = b.wilson;
  return row;
}

}  // namespace

std::vector<PlanRow> bench_plans(std::uint64_t seed, std::size_t trials,
                                 const std::vector<std::string>& scenes, const GoOn& go_on) {
  Cases<PlanRow> cases;
  for (const std::string& name : scenes)
    add_case(cases, [=] { return measured(name, seed, trials); });
  return rows_of(cases, go_on);
}

}  // namespace ferrule
