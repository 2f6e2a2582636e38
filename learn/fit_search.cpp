#include "learn/fit_search.hpp"

#include <ceres/ceres.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "controller/statistics.hpp"
#include "learn/intervals.hpp"
#include "learn/samples.hpp"
#include "learn/shown_search.hpp"

namespace ferrule {
namespace {

using Eigen::Vector3d;

constexpr double kShownLoss = 0.1;               // scale of Cauchy's loss, of the number
constexpr double kPushedLoss = 0.2;              // the same, of the speed
constexpr double kLowest = 0.05, kHighest = 20;  // of the shipped push_force and yield
constexpr double kWidest = 0.5;                  // half an interval, of the number
constexpr std::size_t kFewestShown = 3;          // episodes

// Ceres' residual of something shown: the unknown, in units of a first guess, beside it.
struct ShownError {
  double value;
  template <class T>
  bool operator()(const T* number, T* error) const {
    error[0] = number[0] - value;
    return true;
  }
};

class SearchProblem {
 public:
  SearchProblem(const std::vector<ShownSearch>& episodes, const SearchFile& search)
      : episodes_(episodes), units_(search.gains) {
    std::vector<std::vector<double>> values(units_.size());
    for (const ShownSearch& e : episodes)
      for (const ShownNumber& s : e.shown) values[s.gain].push_back(s.value);
    for (std::size_t i = 0; i < units_.size(); ++i)
      if (!values[i].empty()) units_[i] = quantile(values[i], 0.5);
  }

  // Ceres' report.
  std::string solve() {
    ceres::Problem problem;
    for (const ShownSearch& e : episodes_) {
      for (const ShownNumber& s : e.shown)
        problem.AddResidualBlock(new ceres::AutoDiffCostFunction<ShownError, 1, 1>(
                                     new ShownError{s.value / units_[s.gain]}),
                                 new ceres::CauchyLoss(kShownLoss), &scaled_[s.gain]);
      for (const PushedRow& p : e.pushed)
        problem.AddResidualBlock(
            new ceres::AutoDiffCostFunction<PushedRow, 3, 1, 1, 1>(new PushedRow(p)),
            new ceres::CauchyLoss(kPushedLoss), &scaled_[search_gain::push_force],
            &scaled_[search_gain::yield], &fastest_);
    }
    for (const std::size_t i : {search_gain::push_force, search_gain::yield})
      if (problem.HasParameterBlock(&scaled_[i])) {
        problem.SetParameterLowerBound(&scaled_[i], 0, kLowest);
        problem.SetParameterUpperBound(&scaled_[i], 0, kHighest);
      }
    ceres::Solver::Options options;
    options.max_num_iterations = 200;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    options.function_tolerance = 1e-12;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    return summary.BriefReport();
  }

  // As kSearchGains; without an interval where the episodes do not tell.
  std::vector<FittedGain> gains(const SearchFile& search) const {
    const auto count = static_cast<Eigen::Index>(units_.size()) + 1;  // with `fastest_`
    std::vector<EpisodeSums> sums;
    std::vector<std::size_t> told_by(units_.size());
    for (const ShownSearch& e : episodes_) {
      sums.emplace_back(count);
      add(e, sums.back());
      for (std::size_t i = 0; i < units_.size(); ++i)
        told_by[i] +=
            sums.back().information(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)) > 0;
    }
    const Precision found = precision(sums, std::vector<bool>(units_.size() + 1));
    std::vector<FittedGain> all;
    for (std::size_t i = 0; i < units_.size(); ++i) {
      const double half = found.half_width[static_cast<Eigen::Index>(i)], x = scaled_[i];
      const bool told = told_by[i] >= kFewestShown && half < kWidest * x;
      all.push_back(told ? FittedGain{units_[i] * x, units_[i] * (x - half), units_[i] * (x + half)}
                         : FittedGain{search.gains[i]});
    }
    return all;
  }

 private:
  void add(const ShownSearch& e, EpisodeSums& sums) const {
    for (const ShownNumber& s : e.shown) {
      const auto i = static_cast<Eigen::Index>(s.gain);
      const double error = scaled_[s.gain] - s.value / units_[s.gain];
      const double w = weight(error * error, kShownLoss);
      sums.information(i, i) += w;
      sums.score[i] += w * error;
    }
    const std::array at{static_cast<Eigen::Index>(search_gain::push_force),
                        static_cast<Eigen::Index>(search_gain::yield),
                        static_cast<Eigen::Index>(units_.size())};
    for (const PushedRow& p : e.pushed) {
      using Jet = ceres::Jet<double, 3>;
      const Jet push(scaled_[search_gain::push_force], 0), yielding(scaled_[search_gain::yield], 1),
          fastest(fastest_, 2);
      Jet error[3];
      p(&push, &yielding, &fastest, error);
      double square = 0;
      for (const Jet& each : error) square += each.a * each.a;
      const double w = weight(square, kPushedLoss);
      for (const Jet& each : error) {
        sums.information(at, at) += w * each.v * each.v.transpose();
        sums.score(at) += w * each.a * each.v;
      }
    }
  }

  // Of Cauchy's loss.
  static double weight(double square, double scale) { return 1 / (1 + square / (scale * scale)); }

  const std::vector<ShownSearch>& episodes_;
  std::vector<double> units_;
  std::vector<double> scaled_ = std::vector<double>(kSearchGains.size(), 1.0);
  double fastest_ = 1;
};

// Root mean square of the velocities that are shown, beside the controller's [m/s].
double velocity_error(const std::vector<ShownSearch>& episodes, const SearchFile& c) {
  double sum = 0, n = 0;
  for (const ShownSearch& e : episodes) {
    for (const ShownNumber& s : e.shown)
      if (s.gain == search_gain::approach_speed || s.gain == search_gain::touch_speed ||
          s.gain == search_gain::insert_speed) {
        sum += (s.value - c.gains[s.gain]) * (s.value - c.gains[s.gain]);
        n += 1;
      }
    for (const PushedRow& p : e.pushed) {
      const double push = c.gains[search_gain::push_force] / p.push,
                   yielding = c.gains[search_gain::yield] / p.yield;
      const double fastest = 1;
      double error[3];
      p(&push, &yielding, &fastest, error);
      sum += p.speed * p.speed * Vector3d(error[0], error[1], error[2]).squaredNorm();
      n += 1;
    }
  }
  return n > 0 ? std::sqrt(sum / n) : NAN;
}

SearchFile shipped_search(const DemonstrationSet& set) {
  auto search = std::get<SearchFile>(read_controller("search"));
  const Scaling its = search.trained_on.scaling.value(), now = set.scaling.value();
  if (differ(its, now))
    throw BadInput(fmt::format(
        "a search is fitted in the scaling of bench (motion x{:.6g}, force x{:.6g}); these "
        "episodes have another one (x{:.6g}, x{:.6g})",
        its.motion, its.force, now.motion, now.force));
  return search;
}

// Those of both parts that tell phases.
void keep_with_phases(Split& parts) {
  for (auto* part : {&parts.training, &parts.testing})
    std::erase_if(*part, [](const Demonstration* d) { return d->phases.empty(); });
  if (parts.training.empty() && parts.testing.empty())
    throw BadInput(
        "the episodes tell no phases: a search is fitted to who searches (record --operator "
        "searching, or --operator search)");
  if (parts.training.size() < kFewestShown || parts.testing.empty())
    throw BadInput(
        fmt::format("too few demonstrations that tell phases: {} to learn from and {} held out; "
                    "{} and 1 are needed",
                    parts.training.size(), parts.testing.size(), kFewestShown));
}

Learned learn_search(const DemonstrationSet& set, const LearnerSettings& settings,
                     const LearnerProgress& progress) {
  const SearchFit fit = fit_search(set, settings.seed, progress);
  const SearchFile& c = fit.controller;
  std::string text = fmt::format("{:<16} {:>14} {:>14} {:>14}  {}\n", "number", "value", "95 % low",
                                 "95 % high", "unit");
  for (std::size_t i = 0; i < kSearchGains.size(); ++i) {
    const FittedGain& g = fit.gains[i];
    const bool fitted = std::isfinite(g.low);
    text += fmt::format("{:<16} {:>14.6g} {:>14} {:>14}  {}\n", kSearchGains[i].name, g.value,
                        fitted ? fmt::format("{:.6g}", g.low) : "as in search",
                        fitted ? fmt::format("{:.6g}", g.high) : "", kSearchGains[i].unit);
  }
  text += fmt::format("reaction time {:.2f} s (identified, not imitated)\n", fit.reaction_time);
  text += fmt::format("{} training episodes, {} held out, {} unsuccessful left out, {} rows\n",
                      c.trained_on.episodes.size(), c.trained_on.held_out.size(), set.unsuccessful,
                      c.trained_on.rows);
  text += fmt::format("velocity residual {:.4g} mm/s, held out {:.4g} mm/s (hand)\n{}\n",
                      1e3 * c.residual, 1e3 * c.held_out_residual, fit.summary);
  return {c, text};
}

}  // namespace

SearchFit fit_search(const DemonstrationSet& set, std::uint64_t seed,
                     const LearnerProgress& progress) {
  refuse_too_few(set);
  Split parts = split(set.demonstrations, seed);
  keep_with_phases(parts);
  SearchFit fit;
  SearchFile& c = fit.controller;
  c = shipped_search(set);
  fit.reaction_time = reaction_while_inserting(parts.training);
  const std::vector<ShownSearch> train = shown_by(parts.training, fit.reaction_time, c),
                                 test = shown_by(parts.testing, fit.reaction_time, c);
  if (progress) progress(0, 1, "");
  SearchProblem problem(train, c);
  fit.summary = problem.solve();
  fit.gains = problem.gains(c);
  for (std::size_t i = 0; i < kSearchGains.size(); ++i) {
    const auto& [value, low, high] = fit.gains[i];
    c.gains[i] = value;
    c.sources[i] =
        std::isfinite(low)
            ? fmt::format("fitted; 95 % interval from {:.6g} to {:.6g}", low, high)
            : "as in the shipped search, the demonstrations do not tell: " + c.sources[i];
  }
  c.trained_on = trained_on(set, parts.training, parts.testing, seed);
  for (const ShownSearch& e : train) c.trained_on.rows += e.shown.size() + e.pushed.size();
  c.residual = velocity_error(train, c);
  c.held_out_residual = velocity_error(test, c);
  return fit;
}

Learner search_learner() {
  return {.name = "search",
          .method = "search",
          .options = {},
          .variants = {{"search", "ceres, search", {}}},
          .files = [](const std::string& file) { return std::vector{file}; },
          .learn = learn_search,
          .drawn = false};
}

}  // namespace ferrule
