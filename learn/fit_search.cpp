#include "learn/fit_search.hpp"

#include <ceres/ceres.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "controller/statistics.hpp"
#include "learn/intervals.hpp"
#include "learn/samples.hpp"

namespace ferrule {
namespace {

using Eigen::Vector3d;

constexpr double kEvery = 0.05;              // between rows [s]
constexpr double kBeforeTouch = 0.05;        // the last of the way to it [s]
constexpr double kSlower = 1.5;              // times the touching speed: nearer it slowed down
constexpr double kTurned = 1e-3;             // less is no tilt [rad]
constexpr double kShownLoss = 0.1;           // scale of Cauchy's loss, of the number
constexpr double kPushedLoss = 0.2;          // the same, of the speed
constexpr double kLeast = 0.05, kMost = 20;  // of the shipped push_force and yield
constexpr double kWidest = 0.5;              // half an interval, of the number
constexpr std::size_t kFewestShown = 3;      // episodes

constexpr std::size_t place(std::string_view name) {
  std::size_t i = 0;
  while (kSearchGains[i].name != name) ++i;
  return i;
}
constexpr std::size_t kApproachSpeed = place("approach_speed"), kTouchSpeed = place("touch_speed"),
                      kInsertSpeed = place("insert_speed"), kTiltRate = place("tilt_rate"),
                      kTouchForce = place("touch_force"), kPushForce = place("push_force"),
                      kHoldTime = place("hold_time"), kLift = place("lift"), kTilt = place("tilt"),
                      kYield = place("yield"), kNear = place("near_entrance"),
                      kFibreRadius = place("fibre_radius");

// A number that was seen.
struct Shown {
  std::size_t gain;
  double value;
};

// A row of inserting, for Ceres: what its velocity is beside the law's, in parts of the speed. The
// unknowns are in units of `push`, `yield` and `speed`.
struct Pushed {
  Vector3d force, velocity;
  double speed, push, yield;

  template <class T>
  bool operator()(const T* push_force, const T* yielding, const T* fastest, T* error) const {
    const T most = push * push_force[0];
    error[0] =
        velocity[0] / speed + fastest[0] * fmax(T(0), 1.0 - force.squaredNorm() / (most * most));
    for (int i = 1; i < 3; ++i) error[i] = (velocity[i] - yield * yielding[0] * force[i]) / speed;
    return true;
  }
};

// What one episode shows.
struct Evidence {
  std::vector<Shown> shown;
  std::vector<Pushed> pushed;

  std::vector<double> of(std::size_t gain) const {
    std::vector<double> values;
    for (const Shown& s : shown)
      if (s.gain == gain) values.push_back(s.value);
    return values;
  }
};

double median(const std::vector<double>& values) {
  return quantile(values, 0.5);
}

// Reads the phases of one demonstration.
class Reader {
 public:
  Reader(const Demonstration& d, double reaction, const SearchFile& search)
      : d_(d), reaction_(reaction), search_(search) {
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<double> force;
      for (Eigen::Index n = 0; n < end_row(0); ++n) force.push_back(d.observed(n).wrench[axis]);
      tare_[axis] = median(force);
    }
  }

  Evidence evidence() {
    for (std::size_t k = 0; k < d_.phases.size(); ++k) {
      const std::string& phase = d_.phases[k].name;
      if (phase == "approach" || phase == "lower") come_near(k);
      if (phase == "touch") touch(k);
      if (phase == "release") release(k);
      if (phase == "lift") lift(k);
      if (phase == "move") move(k);
      if (phase == "insert") insert(k);
      if (phase == "straighten") push_ = SearchLaw::kHarder * search_.gains[kPushForce];
    }
    slow_down();
    return found_;
  }

 private:
  std::string next(std::size_t k) const {
    return k + 1 < d_.phases.size() ? d_.phases[k + 1].name : "";
  }
  double end(std::size_t k) const {
    return k + 1 < d_.phases.size() ? d_.phases[k + 1].begin
                                    : d_.period * static_cast<double>(d_.rows());
  }
  Eigen::Index row_from(double time) const {
    return std::min(d_.rows(), static_cast<Eigen::Index>(std::ceil(time / d_.period - 1e-6)));
  }
  Eigen::Index first_row(std::size_t k) const { return row_from(d_.phases[k].begin); }
  Eigen::Index end_row(std::size_t k) const { return row_from(end(k)); }
  void show(std::size_t gain, double value) {
    if (value > 0) found_.shown.push_back({gain, value});
  }
  double speed(Eigen::Index n) const { return -d_.velocity(n, 0); }

  // What was felt where phase k begins, one reaction time before: the axial force [N], and x [m].
  struct Felt {
    double force, x;
  };
  Felt felt(std::size_t k) const {
    const DemonstratedPhase& p = d_.phases[k];
    const double row = (p.begin - reaction_) / d_.period;
    const auto n = static_cast<Eigen::Index>(std::floor(row));
    const bool late = reaction_ > 0 && n + 1 < d_.rows();
    const double part = late && n >= 0 ? row - static_cast<double>(n) : 0.5;
    const Observation &before = late ? d_.observed(n) : p.before,
                      &after = late ? d_.observed(n + 1) : p.then;
    return {(1 - part) * before.wrench[0] + part * after.wrench[0] - tare_[0],
            (1 - part) * before.displacement[0] + part * after.displacement[0]};
  }

  void come_near(std::size_t k) {
    if (d_.phases[k].name == "approach" && !touched_)
      for (Eigen::Index n = first_row(k); n < end_row(k); n += stride_)
        show(kApproachSpeed, speed(n));
    if (next(k) != "touch") return;
    touched_ = true;
    show(kTouchForce, felt(k + 1).force);
    for (Eigen::Index n = std::max(first_row(k), row_from(end(k) - kBeforeTouch)); n < end_row(k);
         ++n)
      show(kTouchSpeed, speed(n));
  }

  void touch(std::size_t k) {
    if (next(k).empty()) return;
    show(kHoldTime, end(k) - d_.phases[k].begin - reaction_);
    const double tilt = d_.phases[k].then.displacement.tail<2>().norm();
    if (tilt > kTurned) show(kTilt, tilt);
  }

  void release(std::size_t k) {
    if (k + 1 == d_.phases.size()) return;
    const Felt from = felt(k), to = felt(k + 1);
    if (to.x > from.x) stiffness_ = (from.force - to.force) / (to.x - from.x);
  }

  // The law lifts further by what the end's rim comes lower by the next tilt.
  void lift(std::size_t k) {
    for (Eigen::Index n = first_row(k); n < end_row(k); n += stride_) show(kInsertSpeed, -speed(n));
    if (!(stiffness_ > 0) || lifted_ || k + 2 >= d_.phases.size()) return;
    lifted_ = true;
    const Felt from = felt(k), to = felt(k + 1);
    const double tilt = d_.phases[k + 2].then.displacement.tail<2>().norm();
    show(kLift, to.x - from.x - from.force / stiffness_ - search_.gains[kFibreRadius] * tilt);
  }

  void move(std::size_t k) {
    double fastest = 0;
    for (Eigen::Index n = first_row(k); n + 1 < end_row(k); ++n)
      fastest = std::max(
          fastest,
          (d_.observed(n + 1).displacement - d_.observed(n).displacement).tail<2>().norm());
    if (fastest > 0.1 * kTurned) show(kTiltRate, fastest / d_.period);
  }

  void insert(std::size_t k) {
    const auto delay = static_cast<Eigen::Index>(std::lround(reaction_ / d_.period));
    const auto felt_at = [&](Eigen::Index n) {
      Vector3d force = d_.observed(n - delay).wrench.head<3>() - tare_;
      force[0] = std::max(0.0, force[0]);
      return force;
    };
    std::vector<double> free;
    for (Eigen::Index n = first_row(k) + delay; n < end_row(k); ++n)
      if (felt_at(n).norm() < search_.gains[kTouchForce]) free.push_back(speed(n));
    const double fast = free.empty() ? 0 : quantile(free, 0.75);
    if (!(fast > 0)) return;
    for (Eigen::Index n = first_row(k) + delay; n < end_row(k); n += stride_)
      found_.pushed.push_back(
          {felt_at(n), d_.velocity.row(n).transpose(), fast, push_, search_.gains[kYield]});
  }

  // Where the first way to a touch, or into the bore, became slow.
  void slow_down() {
    const std::vector<double> far = found_.of(kApproachSpeed), near = found_.of(kTouchSpeed);
    if (far.empty() || near.empty()) return;
    const double fast = median(far), slow = median(near);
    if (fast < kSlower * slow) return;
    for (std::size_t k = 0; k < d_.phases.size(); ++k) {
      if (d_.phases[k].name != "approach" || (next(k) != "touch" && next(k) != "insert")) continue;
      Eigen::Index n = end_row(k);
      while (n > first_row(k) && speed(n - 1) < 0.5 * (fast + slow)) --n;
      if (n > first_row(k) && n < end_row(k)) show(kNear, d_.observed(n).height);
      return;
    }
  }

  const Demonstration& d_;
  double reaction_;
  const SearchFile& search_;
  Eigen::Index stride_ = std::max<Eigen::Index>(1, std::lround(kEvery / d_.period));
  Vector3d tare_ = Vector3d::Zero();
  double stiffness_ = 0, push_ = search_.gains[kPushForce];
  bool touched_ = false, lifted_ = false;
  Evidence found_;
};

std::vector<Evidence> evidence(const std::vector<const Demonstration*>& demonstrations,
                               double reaction, const SearchFile& search) {
  std::vector<Evidence> all;
  for (const Demonstration* d : demonstrations)
    all.push_back(Reader(*d, reaction, search).evidence());
  return all;
}

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
  SearchProblem(const std::vector<Evidence>& episodes, const SearchFile& search)
      : episodes_(episodes), units_(search.gains) {
    for (std::size_t i = 0; i < units_.size(); ++i) {
      std::vector<double> values;
      for (const Evidence& e : episodes)
        for (const double value : e.of(i)) values.push_back(value);
      if (!values.empty()) units_[i] = median(values);
    }
  }

  // Ceres' report.
  std::string solve() {
    ceres::Problem problem;
    for (const Evidence& e : episodes_) {
      for (const Shown& s : e.shown)
        problem.AddResidualBlock(new ceres::AutoDiffCostFunction<ShownError, 1, 1>(
                                     new ShownError{s.value / units_[s.gain]}),
                                 new ceres::CauchyLoss(kShownLoss), &scaled_[s.gain]);
      for (const Pushed& p : e.pushed)
        problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Pushed, 3, 1, 1, 1>(new Pushed(p)),
                                 new ceres::CauchyLoss(kPushedLoss), &scaled_[kPushForce],
                                 &scaled_[kYield], &fastest_);
    }
    for (const std::size_t i : {kPushForce, kYield})
      if (problem.HasParameterBlock(&scaled_[i])) {
        problem.SetParameterLowerBound(&scaled_[i], 0, kLeast);
        problem.SetParameterUpperBound(&scaled_[i], 0, kMost);
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
    std::vector<std::size_t> shown_by(units_.size());
    for (const Evidence& e : episodes_) {
      sums.emplace_back(count);
      add(e, sums.back());
      for (std::size_t i = 0; i < units_.size(); ++i)
        shown_by[i] +=
            sums.back().information(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)) > 0;
    }
    const Precision found = precision(sums, std::vector<bool>(units_.size() + 1));
    std::vector<FittedGain> all;
    for (std::size_t i = 0; i < units_.size(); ++i) {
      const double half = found.half_width[static_cast<Eigen::Index>(i)], x = scaled_[i];
      const bool told = shown_by[i] >= kFewestShown && half < kWidest * x;
      all.push_back(told ? FittedGain{units_[i] * x, units_[i] * (x - half), units_[i] * (x + half)}
                         : FittedGain{search.gains[i]});
    }
    return all;
  }

 private:
  void add(const Evidence& e, EpisodeSums& sums) const {
    for (const Shown& s : e.shown) {
      const auto i = static_cast<Eigen::Index>(s.gain);
      const double error = scaled_[s.gain] - s.value / units_[s.gain];
      const double w = weight(error * error, kShownLoss);
      sums.information(i, i) += w;
      sums.score[i] += w * error;
    }
    const std::array at{static_cast<Eigen::Index>(kPushForce), static_cast<Eigen::Index>(kYield),
                        static_cast<Eigen::Index>(units_.size())};
    for (const Pushed& p : e.pushed) {
      using Jet = ceres::Jet<double, 3>;
      const Jet push(scaled_[kPushForce], 0), yielding(scaled_[kYield], 1), fastest(fastest_, 2);
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

  const std::vector<Evidence>& episodes_;
  std::vector<double> units_;
  std::vector<double> scaled_ = std::vector<double>(kSearchGains.size(), 1.0);
  double fastest_ = 1;
};

// Root mean square of the velocities that are shown, beside the controller's [m/s].
double velocity_error(const std::vector<Evidence>& episodes, const SearchFile& c) {
  double sum = 0, n = 0;
  for (const Evidence& e : episodes) {
    for (const Shown& s : e.shown)
      if (s.gain == kApproachSpeed || s.gain == kTouchSpeed || s.gain == kInsertSpeed) {
        sum += std::pow(s.value - c.gains[s.gain], 2);
        n += 1;
      }
    for (const Pushed& p : e.pushed) {
      const double push = c.gains[kPushForce] / p.push, yielding = c.gains[kYield] / p.yield;
      const double fastest = 1;
      double error[3];
      p(&push, &yielding, &fastest, error);
      sum += p.speed * p.speed * Vector3d(error[0], error[1], error[2]).squaredNorm();
      n += 1;
    }
  }
  return n > 0 ? std::sqrt(sum / n) : NAN;
}

// The rows of its longest insertion: what a hand answers to force elsewhere is not lateral.
Demonstration inserting(const Demonstration& d) {
  double begin = 0, end = 0;
  for (std::size_t k = 0; k < d.phases.size(); ++k) {
    const double from = d.phases[k].begin;
    const bool last = k + 1 == d.phases.size();
    const double to = last ? d.period * static_cast<double>(d.rows()) : d.phases[k + 1].begin;
    if (d.phases[k].name != "insert" || to - from <= end - begin) continue;
    begin = from;
    end = to;
  }
  const auto first = std::lround(begin / d.period), rows = std::lround((end - begin) / d.period);
  Demonstration part = d;
  part.phases.clear();
  part.observations.assign(d.observations.begin() + first, d.observations.begin() + first + rows);
  part.velocity = d.velocity.middleRows(first, rows);
  return part;
}

double reaction_of(const std::vector<const Demonstration*>& demonstrations) {
  std::vector<Demonstration> parts;
  for (const Demonstration* d : demonstrations) parts.push_back(inserting(*d));
  std::vector<const Demonstration*> all;
  for (const Demonstration& part : parts) all.push_back(&part);
  return reaction_time(all);
}

SearchFile shipped_search(const DemonstrationSet& set) {
  auto search = std::get<SearchFile>(read_controller("search"));
  const auto same = [](double a, double b) { return std::abs(a - b) < 1e-9 * b; };
  const Scaling its = search.trained_on.scaling.value(), now = set.scaling.value();
  if (!same(its.motion, now.motion) || !same(its.force, now.force))
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
  fit.reaction_time = reaction_of(parts.training);
  const std::vector<Evidence> train = evidence(parts.training, fit.reaction_time, c),
                              test = evidence(parts.testing, fit.reaction_time, c);
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
  for (const Evidence& e : train) c.trained_on.rows += e.shown.size() + e.pushed.size();
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
          .learn = learn_search};
}

}  // namespace ferrule
