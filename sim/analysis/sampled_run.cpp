#include "sim/analysis/sampled_run.hpp"

#include <algorithm>
#include <cmath>

#include "sim/base/control_period.hpp"
#include "sim/solver/follow.hpp"

namespace ferrule {

SampledRun sample_run(const World& world, const State& start, const std::vector<Pose>& hand,
                      double force_limit, const WatchSample& watch) {
  SampledRun samples;
  follow(
      world, start, std::ssize(hand), kControlPeriod,
      [&](std::ptrdiff_t n) { return hand[static_cast<std::size_t>(n)]; },
      [&](std::ptrdiff_t, const StepResult& r) {
        samples.tip.push_back(r.state.tip.head<3>());
        samples.force.push_back(r.holder.head<3>());
        if (watch) watch(r);
        return holder_force(world, r.holder).norm() <= force_limit;
      });
  return samples;
}

double largest_force(const SampledRun& run) {
  double largest = 0;
  for (const Vector3d& f : run.force) largest = std::max(largest, f.norm());
  return largest;
}

bool snaps(const SampledRun& run, const std::vector<Pose>& hand, double clearance) {
  for (std::size_t n = 1; n < run.tip.size(); ++n) {
    const double moved = (run.tip[n] - run.tip[n - 1]).norm();
    if (moved > 5 * (hand[n] - hand[n - 1]).head<3>().norm() + 0.01 * clearance) return true;
  }
  return false;
}

double run_error(const SampledRun& run, const SampledRun& full, const std::vector<Pose>& hand,
                 const World& world) {
  const std::size_t count = std::min(run.tip.size(), full.tip.size());
  const double clearance = world.annulus.clearance();
  const double scale = std::max(largest_force(full), clearance / world.holder.compliance());
  double worst = 0;
  for (std::size_t n = 0; n < count; ++n) {
    double best = INFINITY;
    const auto compare = [&](std::size_t m, double travel) {
      const double tip = (run.tip[n] - full.tip[m]).norm() / clearance;
      const double force = (run.force[n] - full.force[m]).norm() / scale;
      best = std::min(best, std::max({tip, force, travel}));
    };
    compare(n, 0);
    for (const int way : {-1, 1})
      for (std::size_t k = 1; best > worst && k < count; ++k) {
        if (way < 0 ? k > n : n + k >= count) break;
        const std::size_t m = way < 0 ? n - k : n + k;
        const double travel = (hand[m] - hand[n]).head<3>().norm() / clearance;
        if (k > 1 && travel >= best) break;
        compare(m, k == 1 ? 0 : travel);
      }
    worst = std::max(worst, best);
  }
  return worst;
}

}  // namespace ferrule
