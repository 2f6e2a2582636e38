#include "bench/events.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "bench/random_scene.hpp"
#include "sim/base/control_period.hpp"
#include "sim/geometry/energy.hpp"
#include "sim/scene/draw.hpp"
#include "sim/solver/step.hpp"

namespace ferrule {
namespace {

constexpr std::array<int, 7> kParts = {64, 32, 16, 8, 4, 2, 1};

struct Trace {
  std::vector<PoseVector> tips;  // every kControlPeriod
  std::vector<Vector3d> forces;
  double seconds = 0;
  long not_converged = 0, capped = 0;
};

Trace follow_hand(const World& world, const State& start, const std::vector<Pose>& hand,
                  int parts) {
  Trace trace;
  StepResult r(start);
  const auto begin = std::chrono::steady_clock::now();
  for (std::size_t n = 0; n < hand.size(); ++n) {
    step_on(world, hand[n], n == 0 ? 0 : kControlPeriod / parts, r);
    trace.not_converged += r.status == StepStatus::not_converged;
    trace.capped += r.status == StepStatus::iteration_limit;
    if (n % static_cast<std::size_t>(parts) != 0) continue;
    trace.tips.emplace_back(r.state.tip);
    trace.forces.emplace_back(r.holder.head<3>());
  }
  trace.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return trace;
}

void compare(const World& world, const Trace& trace, const Trace& finest, EventRow& row) {
  std::vector<double> off;
  double largest = 0;
  for (std::size_t n = 0; n < finest.tips.size(); ++n) {
    const PoseVector &a = trace.tips[n], &b = finest.tips[n];
    const double at_mouth = std::max(0.0, -b.x);
    const double apart =
        std::max((a - b).length(), (eccentricity(a, at_mouth) - eccentricity(b, at_mouth)).norm());
    row.pose_difference_clearances =
        std::max(row.pose_difference_clearances, apart / world.annulus.clearance());
    off.push_back((trace.forces[n] - finest.forces[n]).norm());
    largest = std::max(largest, (finest.forces[n] - finest.forces[0]).norm());
  }
  if (!(largest > 0)) return;
  row.force_difference_relative =
      std::max(row.force_difference_relative, *std::max_element(off.begin(), off.end()) / largest);
  row.share_above_1_percent += static_cast<double>(
      std::count_if(off.begin(), off.end(), [&](double force) { return force > 0.01 * largest; }));
}

void add_rows(const std::string& name, Motion motion, std::uint64_t seed, std::size_t starts,
              std::vector<EventRow>& rows) {
  const Scene scene = load_scene(name);
  std::array<EventRow, kParts.size()> mine;
  double samples = 0;
  for (std::size_t i = 0; i < kParts.size(); ++i)
    mine[i] = {name, ferrule::name(motion), kControlPeriod / kParts[i], 0, 0, 0, 0, 0, 0};
  for (std::size_t k = 0; k < starts; ++k) {
    const State start = draw_start(scene, seed, k);
    Trace finest;
    for (std::size_t i = 0; i < kParts.size(); ++i) {
      const auto hand = commands(scene, start, motion, kControlPeriod / kParts[i], seed, k);
      const Trace trace = follow_hand(scene.world, start, hand, kParts[i]);
      if (i == 0) finest = trace;
      compare(scene.world, trace, finest, mine[i]);
      mine[i].us_per_simulated_s += 1e6 * trace.seconds;
      mine[i].not_converged += trace.not_converged;
      mine[i].capped += trace.capped;
    }
    samples += static_cast<double>(finest.tips.size());
  }
  for (auto row = mine.rbegin(); row != mine.rend(); ++row) {
    row->us_per_simulated_s /= samples * kControlPeriod;
    row->share_above_1_percent /= samples;
    rows.push_back(*row);
  }
}

}  // namespace

std::vector<EventRow> bench_events(std::uint64_t seed, std::size_t starts,
                                   const std::vector<std::string>& scenes, const GoOn& go_on) {
  Cases<EventRow> cases;
  for (const std::string& name : scenes)
    for (int motion = 0; motion < kMotions; ++motion)
      cases.push_back([=](std::vector<EventRow>& rows) {
        add_rows(name, static_cast<Motion>(motion), seed, starts, rows);
      });
  return rows_of(cases, go_on);
}

}  // namespace ferrule
