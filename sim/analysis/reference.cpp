#include "sim/analysis/reference.hpp"

#include <algorithm>

#include "sim/base/control_period.hpp"
#include "sim/solver/extrapolation.hpp"
#include "sim/solver/follow.hpp"
#include "sim/solver/step.hpp"

namespace ferrule {
namespace {

constexpr std::size_t kEveryForSteps = 5;        // from which a step is compared
constexpr std::size_t kEveryForIntervals = 500;  // and an interval
constexpr double kMost = 0.95;  // of steps and intervals, whose error is below the bound

// The value that all but a few are below.
double most_of(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(kMost * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace

Reference::Reference(Scene full, Runs& watched)
    : scene(std::move(full)),
      watch(watched),
      compliance(scene.world.holder.compliance()),
      clearance(scene.world.annulus.clearance()) {
  const World& world = scene.world;
  for (std::uint64_t k = 0; k < probes_of(scene) && watch.next(); ++k) {
    probes.push_back(make_probe(scene, k));
    const Probe& p = probes.back();
    std::size_t number = 0;
    std::vector<State>& begin = intervals.emplace_back();
    runs.push_back(sample_run(world, p.start, p.hand, scene.limits.force, [&](const StepResult& r) {
      const State& s = r.state;
      if (number++ % kEveryForIntervals == 0) begin.push_back(s);
      if (!r.extrapolated()) find_extremes(r);
    }));
    force_scale = std::min(force_scale, largest_force(runs.back()));
    sticks = sticks || snaps(runs.back(), p.hand, clearance);
  }
  sticks = sticks || extreme(Term::friction).force > 0 ||
           depends_on_speed(world.laws);  // drag slows a snap down and hides it
  force_scale = std::max(force_scale, clearance / compliance);
}

void Reference::find_extremes(const StepResult& now) {
  const Breakdown breakdown = forces(scene.world, now);
  for (const Term term : kAllTerms) {
    const double force = breakdown.force(term).norm();
    Extreme& most = extremes[static_cast<std::size_t>(term)];
    if (force > most.force) most = {force, now.state};
  }
}

double Reference::error(const World& reduced) const {
  double worst = 0;
  for (std::size_t k = 0; k < probes.size(); ++k) {
    if (!watch.next()) return INFINITY;
    const Probe& p = probes[k];
    const SampledRun r = sample_run(reduced, p.start, p.hand, INFINITY);
    worst = std::max(worst, run_error(r, runs[k], p.hand, scene.world));
  }
  return worst;
}

double Reference::error_of_steps(const World& reduced, const World& full) const {
  std::vector<double> errors;
  for (std::size_t k = 0; k < std::min(kProbesForSteps, probes.size()); ++k) {
    if (!watch.next()) return INFINITY;
    const std::vector<Pose>& hand = probes[k].hand;
    StepResult reached(probes[k].start);
    for (std::size_t n = 0; n < runs[k].tip.size(); ++n) {
      const double dt = n == 0 ? 0 : kControlPeriod;
      const bool compared = n % kEveryForSteps == 0;
      const State before = compared ? end_extrapolation(reduced, reached) : State();
      step_on(reduced, hand[n], dt, reached);
      if (!compared) continue;
      const StepResult exact = step(full, before, hand[n], dt);
      const Vector3d force = (reached.holder - exact.holder).head<3>();
      errors.push_back(std::max((reached.state.tip - exact.state.tip).head<3>().norm() / clearance,
                                force.norm() / force_scale));
    }
  }
  return most_of(std::move(errors));
}

double Reference::error_of_intervals() const {
  constexpr auto length = static_cast<std::size_t>(kSpeedingUp / kControlPeriod);
  WorldParameters p = scene.parameters;
  p.numerics.longest_step /= kFiner;
  const World finer = make_world(p);
  std::vector<double> errors;
  for (std::size_t k = 0; k < probes.size(); ++k) {
    if (!watch.next()) return INFINITY;
    for (std::size_t i = 0; i < intervals[k].size(); ++i) {
      const auto from = static_cast<std::ptrdiff_t>(i * kEveryForIntervals);
      const auto to = static_cast<std::ptrdiff_t>(
          std::min(i * kEveryForIntervals + length, runs[k].tip.size()));
      const auto part = [&](const auto& all) {
        return std::remove_cvref_t<decltype(all)>(all.begin() + from, all.begin() + to);
      };
      const SampledRun run{part(runs[k].tip), part(runs[k].force)};
      const std::vector<Pose> hand = part(probes[k].hand);
      SampledRun exact{{run.tip.front()}, {run.force.front()}};
      State state = intervals[k][i];
      for (std::size_t n = 1; n < hand.size(); ++n) {
        const StepResult reached = step(finer, state, hand[n], kControlPeriod);
        state = reached.state;
        exact.tip.push_back(state.tip.head<3>());
        exact.force.push_back(reached.holder.head<3>());
      }
      errors.push_back(run_error(run, exact, hand, scene.world));
    }
  }
  return most_of(std::move(errors));
}

double Reference::sampled_twice() const {
  WorldParameters p = scene.parameters;
  if (p.dynamics == Dynamics::quasi_static) p.numerics.longest_step *= 0.5;
  p.numerics.extrapolation_tip = 0;
  const World finer = make_world(p);
  double worst = 0;
  for (std::size_t k = 0; k < std::min(kResampled, probes.size()) && watch.next(); ++k) {
    const std::vector<Pose>& hand = probes[k].hand;
    SampledRun twice;
    follow(
        finer, probes[k].start, 2 * std::ssize(runs[k].tip) - 1, 0.5 * kControlPeriod,
        [&](std::ptrdiff_t n) {
          const auto i = static_cast<std::size_t>(n / 2);
          return n % 2 == 0 ? hand[i] : Pose(0.5 * (hand[i] + hand[i + 1]));
        },
        [&](std::ptrdiff_t n, const StepResult& r) {
          if (n % 2 != 0) return true;
          twice.tip.push_back(r.state.tip.head<3>());
          twice.force.push_back(r.holder.head<3>());
          return true;
        });
    worst = std::max(worst, run_error(twice, runs[k], hand, scene.world));
  }
  return worst;
}

}  // namespace ferrule
