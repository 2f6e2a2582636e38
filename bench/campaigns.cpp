#include "bench/campaigns.hpp"

#include <algorithm>

#include "controller/law.hpp"
#include "controller/trial.hpp"
#include "insertion/scene_scaling.hpp"
#include "learn/candidates.hpp"
#include "sim/base/measure.hpp"
#include "sim/solver/follow.hpp"

namespace ferrule {
namespace {

constexpr std::uint64_t kSeed = 7, kTrials = 20;

// The commands of one trial, in the scene of its parts.
struct Recorded {
  std::shared_ptr<const Scene> scene;
  State start;
  std::vector<Pose> hand;
};

Recorded record(const Scene& toleranced, std::uint64_t trial, double period) {
  const auto setup = trial_setup(toleranced, kSeed, trial);
  if (!setup) return {};
  const Scene& scene = *setup->scene;
  Recorded recorded{setup->scene, setup->start, {}};
  const double speed = setup->scaling.motion * scene.limits.speed;
  Law law = tuned_by_hand(speed);
  ControllerHand hand(law, setup->hand(), speed, INFINITY, registered_entrance(scene));
  run_insertion(*setup, hand, {.period = period, .past_success = false}, [&](const Tick& tick) {
    recorded.hand.push_back(tick.result.state.command);
    return true;
  });
  return recorded;
}

CampaignRow measured(const std::string& name, double period) {
  const Scene scene = load_scene(name);
  CampaignRow row{name, "tuned by hand", period, 0, 0, 0, 0, 0, 0, 0};
  long in_contact = 0, iterations = 0, evaluations = 0;
  double ns = 0;
  for (std::uint64_t trial = 0; trial < kTrials; ++trial) {
    const Recorded recorded = record(scene, trial, period);
    if (!recorded.scene) continue;
    const auto play = [&](const auto& each) {
      follow(
          recorded.scene->world, recorded.start, std::ssize(recorded.hand), period,
          [&](std::ptrdiff_t n) { return recorded.hand[static_cast<std::size_t>(n)]; }, each);
    };
    play([&](std::ptrdiff_t, const StepResult& r) {
      ++row.steps;
      row.not_converged += r.status == StepStatus::not_converged;
      row.capped += r.status == StepStatus::iteration_limit;
      evaluations += r.evaluations;
      row.evaluations_max = std::max<long>(row.evaluations_max, r.evaluations);
      const auto& contact = r.state.contact;
      if (!contact[kEnd].closed && !contact[kSide].closed) return true;
      ++in_contact;
      iterations += r.iterations;
      return true;
    });
    ns += nanoseconds_per_call(
        [&](long) {
          play([](std::ptrdiff_t, const StepResult& r) {
            keep(r.state.tip);
            return true;
          });
        },
        1e6);
  }
  const auto steps = static_cast<double>(row.steps);
  row.ns_per_step = ns / steps;
  row.evaluations = static_cast<double>(evaluations) / steps;
  row.iterations_in_contact =
      in_contact ? static_cast<double>(iterations) / static_cast<double>(in_contact) : 0;
  return row;
}

}  // namespace

std::vector<CampaignRow> bench_campaigns(const GoOn& go_on) {
  Cases<CampaignRow> cases;
  for (const double period : {1e-3, 1e-2})
    for (const std::string& name : shipped_scenes())
      add_case(cases, [=] { return measured(name, period); });
  return rows_of(cases, go_on);
}

}  // namespace ferrule
