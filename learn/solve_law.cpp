#include "learn/solve_law.hpp"

#include <ceres/ceres.h>

#include <algorithm>

#include "learn/intervals.hpp"
#include "learn/law_cost.hpp"

namespace ferrule {
namespace {

constexpr std::size_t kStartStride = 5;  // of rows that tell starts apart

// Unit that a gain of order one is multiplied by, and bounds of the scaled gain. Slowing and
// yielding are not negative: a law that goes faster where it is pushed back is not passive.
struct Scaled {
  double unit, low, high;
};

std::vector<Scaled> scaled_gains(LawKind kind, const LawScales& scales) {
  const double speed = scales.speed, depth = scales.depth;
  const Scaled drift{speed, -4, 4}, yield{speed, 0, 20};
  std::vector<Scaled> all = {drift,     drift, drift, yield, yield, yield, {depth, 1e-2, 10},
                             drift,     drift, drift, yield, yield, yield, {1, 0, 10},
                             {1, 0, 20}};
  if (is_insertion_law(kind)) {
    const Scaled lean{speed / depth, -4, 4};
    all = {{speed, 0, 4},
           {1, 1e-4, 30},
           {depth, 0.2, 10},
           {depth, 1e-2, 10},
           {1, 0, 1e3},
           yield,
           yield,
           yield,
           drift,
           drift,
           lean,
           lean,
           yield,
           yield};
  }
  all.resize(gain_table(kind).size());
  return all;
}

LawUnits units_of(const std::vector<Scaled>& gains, double speed) {
  LawUnits units{{}, speed};
  for (const Scaled& gain : gains) units.gains.push_back(gain.unit);
  return units;
}

struct Start {
  std::vector<double> scaled;
  bool solved;  // of the law within this one: may be the solution already
};

std::vector<Start> starts(LawKind kind, const std::vector<Samples>& episodes,
                          const LawScales& scales) {
  std::vector<Start> all;
  switch (kind) {
    case LawKind::insertion:
      for (const double ramp : {1.0, 5.0})
        for (const double length : {0.05, 0.5})
          all.push_back({{1, ramp, 1.1, length, 0.1, 0.01, 0.5, 0.5, 0, 0, 0, 0}, false});
      break;
    case LawKind::guarded: {
      std::vector<double> scaled =
          solve_law(LawKind::insertion, episodes, scales, Effort::rough).scaled;
      if (!scaled.empty()) scaled.insert(scaled.end(), {scaled[6], scaled[7]});
      all.push_back({scaled, true});
      break;
    }
    case LawKind::linear:
      all.push_back({{-0.5, 0, 0, 0.01, 0.5, 0.5}, false});
      break;
    case LawKind::phased: {
      const std::vector<double> linear =
          solve_law(LawKind::linear, episodes, scales, Effort::rough).scaled;
      for (const double length : {0.03, 0.3, 3.0}) {
        all.push_back({linear, true});
        all.back().scaled.push_back(length);
        all.back().scaled.insert(all.back().scaled.end(), linear.begin(), linear.end());
      }
      break;
    }
    case LawKind::saturated: {
      const std::vector<double> phased =
          solve_law(LawKind::phased, episodes, scales, Effort::rough).scaled;
      for (const auto& [dead_band, saturation] :
           {std::pair{0.0, 0.0}, {0.02, 0.1}, {0.02, 1.0}, {0.3, 0.1}}) {
        all.push_back({phased, true});
        all.back().scaled.push_back(dead_band);
        all.back().scaled.push_back(saturation);
      }
      break;
    }
  }
  return all;
}

// Ends a solve where it is no longer wanted.
class Watch : public ceres::IterationCallback {
 public:
  explicit Watch(const std::function<bool()>& go_on) : go_on_(go_on) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
    return go_on_() ? ceres::SOLVER_CONTINUE : ceres::SOLVER_TERMINATE_SUCCESSFULLY;
  }

 private:
  const std::function<bool()>& go_on_;
};

LawSolution solve_from(LawKind kind, const std::vector<Samples>& episodes,
                       const std::vector<Scaled>& gains, double speed, const Start& start,
                       bool bounded, Effort effort, const std::function<bool()>& go_on,
                       const std::vector<int>& held = {}) {
  LawSolution s{{}, start.scaled, INFINITY, {}, 0};
  ceres::Problem problem;
  const LawUnits units = units_of(gains, speed);
  for (const Samples& episode : episodes)
    problem.AddResidualBlock(episode_cost(kind, episode, units).release(), nullptr,
                             s.scaled.data());
  for (std::size_t i = 0; bounded && i < gains.size(); ++i) {
    problem.SetParameterLowerBound(s.scaled.data(), static_cast<int>(i), gains[i].low);
    problem.SetParameterUpperBound(s.scaled.data(), static_cast<int>(i), gains[i].high);
  }
  if (!held.empty())
    problem.SetManifold(s.scaled.data(),
                        new ceres::SubsetManifold(static_cast<int>(gains.size()), held));
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 300;
  options.function_tolerance = effort == Effort::exact ? 1e-15 : 1e-6;
  options.gradient_tolerance = 1e-14;
  options.parameter_tolerance = 1e-12;
  options.logging_type = ceres::SILENT;
  Watch watch(go_on);
  options.callbacks.push_back(&watch);
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  s.iterations = static_cast<int>(summary.num_successful_steps);
  s.summary = summary.BriefReport();
  // A fit that took no step has not been tried; keep it only as a failure.
  if (summary.IsSolutionUsable() && (s.iterations > 0 || start.solved)) s.cost = summary.final_cost;
  return s;
}

bool within_bounds(const std::vector<double>& scaled, const std::vector<Scaled>& gains) {
  for (std::size_t i = 0; i < gains.size(); ++i)
    if (scaled[i] < gains[i].low - 1e-6 || scaled[i] > gains[i].high + 1e-6) return false;
  return true;
}

bool at_bound(double scaled, const Scaled& gain) {
  return scaled - gain.low <= 1e-3 * std::abs(gain.low) + 1e-9 ||
         gain.high - scaled <= 1e-2 * gain.high;
}

}  // namespace

LawSolution solve_law(LawKind kind, const std::vector<Samples>& episodes, const LawScales& scales,
                      Effort effort, const SolveProgress& progress) {
  const std::vector<Scaled> gains = scaled_gains(kind, scales);
  constexpr std::size_t kRefined = 2;  // solves after the rough ones
  std::size_t done = 0, all = kRefined;
  bool stopped = false;
  const std::function<bool()> go_on = [&] {
    stopped |= progress && !progress(done, all);
    return !stopped;
  };
  const auto solve = [&](const std::vector<Samples>& rows, const Start& start, bool bounded) {
    LawSolution s = solve_from(kind, rows, gains, scales.speed, start, bounded, effort, go_on);
    ++done;
    return s;
  };
  LawSolution best{{}, {}, INFINITY, "no start", 0};
  if (effort == Effort::rough) {
    const std::vector<Start> from = starts(kind, episodes, scales);
    all = from.size() + kRefined;
    for (const Start& start : from) {
      if (start.scaled.size() != gains.size()) continue;  // the law within has no solution
      if (!go_on()) break;
      LawSolution s = solve(episodes, start, true);
      if (s.cost < best.cost || best.scaled.empty()) best = std::move(s);
    }
    if (!std::isfinite(best.cost)) return best;
  } else {
    // Fewer rows suffice to compare the starts.
    std::vector<Samples> fewer;
    for (const Samples& episode : episodes) fewer.push_back(thinned(episode, kStartStride));
    LawSolution rough =
        solve_law(kind, fewer, scales, Effort::rough, [&](std::size_t so_far, std::size_t of) {
          done = so_far;
          all = of;
          return go_on();
        });
    if (!std::isfinite(rough.cost) || stopped) return rough;
    best = solve(episodes, {rough.scaled, true}, true);
    if (!std::isfinite(best.cost)) return best;
    // Bounds slow the last digits down where the data hold a gain close to one; without them the
    // solution may be reached, and is kept if it respects them.
    const LawSolution free = stopped ? best : solve(episodes, {best.scaled, false}, false);
    if (free.cost < best.cost && within_bounds(free.scaled, gains)) best = free;
  }
  for (std::size_t i = 0; i < gains.size(); ++i)
    best.gains.push_back(best.scaled[i] * gains[i].unit);
  return best;
}

LawSolution solve_beside(LawKind kind, const std::vector<Samples>& episodes,
                         const LawScales& scales, const LawSolution& from,
                         const std::vector<double>& held, const SolveProgress& progress) {
  const std::vector<Scaled> gains = scaled_gains(kind, scales);
  Start start{from.scaled, true};
  std::vector<int> constant;
  for (std::size_t i = 0; i < gains.size(); ++i) {
    if (std::isnan(held[i])) continue;
    start.scaled[i] = std::clamp(held[i] / gains[i].unit, gains[i].low, gains[i].high);
    constant.push_back(static_cast<int>(i));
  }
  const std::function<bool()> go_on = [&] { return !progress || progress(1, 1); };
  LawSolution s =
      solve_from(kind, episodes, gains, scales.speed, start, true, Effort::exact, go_on, constant);
  s.iterations += from.iterations;
  for (std::size_t i = 0; i < gains.size(); ++i) s.gains.push_back(s.scaled[i] * gains[i].unit);
  return s;
}

std::vector<FittedGain> law_gains(LawKind kind, const std::vector<Samples>& episodes,
                                  const LawScales& scales, const LawSolution& solution) {
  const std::vector<Scaled> gains = scaled_gains(kind, scales);
  std::vector<bool> fixed;
  for (std::size_t i = 0; i < gains.size(); ++i)
    fixed.push_back(at_bound(solution.scaled[i], gains[i]));
  std::vector<EpisodeSums> each;
  for (const Samples& episode : episodes)
    each.push_back(episode_sums(kind, episode, units_of(gains, scales.speed), solution.scaled));
  const Eigen::VectorXd half = precision(each, fixed).half_width;
  std::vector<FittedGain> fitted;
  for (std::size_t i = 0; i < gains.size(); ++i) {
    const Scaled& g = gains[i];
    const double x = solution.scaled[i], h = half[static_cast<Eigen::Index>(i)];
    fitted.push_back({solution.gains[i], NAN, NAN});
    if (std::isfinite(h)) {
      fitted.back().low = std::max(x - h, g.low) * g.unit;
      fitted.back().high = std::min(x + h, g.high) * g.unit;
    }
  }
  return fitted;
}

double mean_square_error(const Law& law, const Samples& episode) {
  double sum = 0;
  for (const Sample& s : episode)
    sum += (law_velocity(law.kind(), law.gains().data(), s) - s.velocity).squaredNorm();
  return sum / static_cast<double>(episode.size());
}

}  // namespace ferrule
