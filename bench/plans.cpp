#include "bench/plans.hpp"

#include <algorithm>
#include <array>
#include <ctime>
#include <functional>

#include "controller/campaign.hpp"
#include "insertion/scene_scaling.hpp"
#include "learn/candidates.hpp"

namespace ferrule {
namespace {

constexpr double kTolerance = 0.01;
constexpr int kTurns = 3;

double processor_seconds(const std::function<void()>& work) {
  const std::clock_t before = std::clock();
  work();
  return static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC;
}

struct Campaign {
  std::vector<TrialResult> results;
  std::array<double, kTurns> us_per_simulated_s{};

  double median_us() const {
    auto sorted = us_per_simulated_s;
    std::sort(sorted.begin(), sorted.end());
    return sorted[kTurns / 2];
  }
};

void run(const Scene& scene, std::uint64_t seed, std::size_t trials, int turn, Campaign& campaign) {
  const Scaling scaling = scene_scaling(scene);
  const MakeController make = [&](std::uint64_t) {
    return std::make_unique<InsertionLaw>(tuned_by_hand(scaling.motion * scene.limits.speed));
  };
  const double seconds = processor_seconds(
      [&] { campaign.results = run_campaign(scene, scaling, make, seed, trials, 1, {}); });
  double simulated = 0;
  for (const TrialResult& r : campaign.results) simulated += r.summary.time;
  campaign.us_per_simulated_s[static_cast<std::size_t>(turn)] = 1e6 * seconds / simulated;
}

PlanRow measured(const std::string& name, PlanFor quantity, std::uint64_t seed,
                 std::size_t trials) {
  const Scene scene = load_scene(name);
  PlanRow row{};
  row.scene = name;
  row.plan_for = quantity == PlanFor::success ? "success" : "motion";
  Plan plan;
  row.planning_s = processor_seconds([&] { plan = make_plan(scene, kTolerance, {}, quantity); });
  row.error_bound = plan.error_bound;
  row.sampled_twice = plan.sampled_twice;
  const Scene planned = parse_scene(plan.document, name);
  Json document = scene.document;
  document["quadrature"] = 16;
  const Scene full = parse_scene(document, name);
  Campaign of_full, of_planned;
  for (int turn = 0; turn < kTurns; ++turn) {
    run(full, seed, trials, turn, of_full);
    run(planned, seed, trials, turn, of_planned);
  }
  row.full_us_per_simulated_s = of_full.median_us();
  row.planned_us_per_simulated_s = of_planned.median_us();
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
    for (const PlanFor quantity : {PlanFor::motion, PlanFor::success})
      add_case(cases, [=] { return measured(name, quantity, seed, trials); });
  return rows_of(cases, go_on);
}

}  // namespace ferrule
