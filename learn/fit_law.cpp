#include "learn/fit_law.hpp"

#include <ceres/ceres.h>
#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>

#include "learn/samples.hpp"

namespace ferrule {
namespace {

using Gains = std::array<double, kGains>;
using Eigen::Vector3d;

constexpr double kHuber = 0.2;  // of the speed scale
constexpr std::size_t kFewestEpisodes = 3, kFewestRows = 300;
constexpr double kLeastForce = 0.001;  // standard deviation of felt force that tells anything [N]

// Gains of order one are multiplied by these.
struct Units {
  Gains value;
  explicit Units(double speed, double depth)
      : value{speed, 1,     depth,         depth,        1, speed, speed, speed,
              speed, speed, speed / depth, speed / depth} {}
};
// Bounds of the scaled gains. Slowing and yielding are not negative: a law that goes faster where
// it is pushed back is not passive.
constexpr Gains kLow = {0, 1e-4, 0.2, 1e-2, 0, 0, 0, 0, -4, -4, -4, -4};
constexpr Gains kHigh = {4, 30, 10, 10, 1e3, 20, 20, 20, 4, 4, 4, 4};

struct RowError {
  const Sample& sample;
  const Units& units;
  double speed;

  template <class T>
  bool operator()(const T* scaled, T* residual) const {
    T gains[kGains];
    for (std::size_t i = 0; i < kGains; ++i) gains[i] = scaled[i] * units.value[i];
    const Eigen::Matrix<T, 3, 1> v =
        insertion_velocity(gains, sample.force, sample.depth, sample.time);
    for (int axis = 0; axis < 3; ++axis) residual[axis] = (v[axis] - sample.velocity[axis]) / speed;
    return true;
  }
};

using RowCost = ceres::AutoDiffCostFunction<RowError, 3, kGains>;

struct Solution {
  Gains scaled{};
  double cost = INFINITY;
  std::string summary;
  int iterations = 0;
};

Solution solve(const std::vector<Samples>& episodes, const Units& units, double speed,
               const Gains& start, bool bounded) {
  Solution s;
  s.scaled = start;
  ceres::Problem problem;
  auto* loss = new ceres::HuberLoss(kHuber);
  for (const Samples& episode : episodes)
    for (const Sample& sample : episode)
      problem.AddResidualBlock(new RowCost(new RowError{sample, units, speed}), loss,
                               s.scaled.data());
  for (int i = 0; bounded && i < kGains; ++i) {
    problem.SetParameterLowerBound(s.scaled.data(), i, kLow[static_cast<std::size_t>(i)]);
    problem.SetParameterUpperBound(s.scaled.data(), i, kHigh[static_cast<std::size_t>(i)]);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 300;
  options.function_tolerance = 1e-15;
  options.gradient_tolerance = 1e-14;
  options.parameter_tolerance = 1e-12;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  s.iterations = static_cast<int>(summary.num_successful_steps);
  s.summary = summary.BriefReport();
  // A fit that took no step has not been tried; keep it only as a failure.
  if (summary.IsSolutionUsable() && s.iterations > 0) s.cost = summary.final_cost;
  return s;
}

bool within_bounds(const Gains& scaled) {
  for (std::size_t i = 0; i < kGains; ++i)
    if (scaled[i] < kLow[i] - 1e-6 || scaled[i] > kHigh[i] + 1e-6) return false;
  return true;
}

bool at_bound(const Gains& scaled, std::size_t i) {
  return scaled[i] - kLow[i] <= 1e-3 * std::abs(kLow[i]) + 1e-9 ||
         kHigh[i] - scaled[i] <= 1e-2 * kHigh[i];
}

// Half widths of the 95 % intervals of the scaled gains; NaN where the data leave one open.
Gains half_widths(const std::vector<Samples>& episodes, const Units& units, double speed,
                  const Gains& scaled) {
  std::vector<Eigen::Index> open;
  for (std::size_t i = 0; i < kGains; ++i)
    if (!at_bound(scaled, i)) open.push_back(static_cast<Eigen::Index>(i));
  using Matrix = Eigen::Matrix<double, kGains, kGains>;
  Matrix bread = Matrix::Zero(), meat = Matrix::Zero();
  for (const Samples& episode : episodes) {
    Eigen::Matrix<double, kGains, 1> score = Eigen::Matrix<double, kGains, 1>::Zero();
    for (const Sample& sample : episode) {
      const RowCost cost(new RowError{sample, units, speed});
      Eigen::Matrix<double, 3, kGains, Eigen::RowMajor> jacobian;
      Vector3d residual;
      const double* parameters[] = {scaled.data()};
      double* jacobians[] = {jacobian.data()};
      cost.Evaluate(parameters, residual.data(), jacobians);
      const double size = residual.norm();
      const double weight = size > kHuber ? kHuber / size : 1;  // Huber's
      bread += weight * jacobian.transpose() * jacobian;
      score += weight * jacobian.transpose() * residual;
    }
    meat += score * score.transpose();
  }
  const Eigen::MatrixXd b = bread(open, open), m = meat(open, open);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(b);
  Gains half;
  half.fill(NAN);
  if (!(eigen.eigenvalues()[0] > 1e-12 * eigen.eigenvalues()[eigen.eigenvalues().size() - 1]))
    return half;
  const Eigen::MatrixXd inverse = b.inverse();
  const Eigen::MatrixXd covariance = inverse * m * inverse;
  const double g = static_cast<double>(episodes.size());
  const double t = quantile(boost::math::students_t(g - 1), 0.975) * std::sqrt(g / (g - 1));
  for (std::size_t k = 0; k < open.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k);
    half[static_cast<std::size_t>(open[k])] = t * std::sqrt(std::max(0.0, covariance(at, at)));
  }
  return half;
}

double root_mean_square(const std::vector<Samples>& episodes, const Gains& gains) {
  double sum = 0, n = 0;
  for (const Samples& episode : episodes)
    for (const Sample& s : episode) {
      sum +=
          (insertion_velocity(gains.data(), s.force, s.depth, s.time) - s.velocity).squaredNorm();
      n += 1;
    }
  return n > 0 ? std::sqrt(sum / n) : NAN;
}

void refuse_uninformative(const std::vector<Samples>& episodes) {
  std::size_t rows = 0;
  Vector3d sum = Vector3d::Zero(), squares = Vector3d::Zero();
  for (const Samples& episode : episodes)
    for (const Sample& s : episode) {
      ++rows;
      sum += s.force;
      squares += s.force.cwiseAbs2();
    }
  if (rows < kFewestRows)
    throw BadInput(fmt::format("too little data: {} rows in steps of 10 ms; {} are needed", rows,
                               kFewestRows));
  const double n = static_cast<double>(rows);
  const Vector3d sd = (squares / n - (sum / n).cwiseAbs2()).cwiseMax(0.0).cwiseSqrt();
  for (const int axis : {1, 2})
    if (sd[axis] < kLeastForce)
      throw BadInput(fmt::format(
          "the demonstrations tell nothing about the answer to force: the felt F_{} varies by "
          "{:.2g} N (standard deviation), {} N is needed; record misaligned starts",
          "xyz"[axis], sd[axis], kLeastForce));
}

}  // namespace

FitReport fit_law(const DemonstrationSet& set, std::uint64_t seed) {
  const auto& all = set.demonstrations;
  if (all.size() < kFewestEpisodes)
    throw BadInput(fmt::format(
        "too few demonstrations: {} successful ({} unsuccessful left out); {} are needed",
        all.size(), set.unsuccessful, kFewestEpisodes));

  const auto [training, testing] = split(all, seed);

  FitReport report;
  ControllerFile& c = report.controller;
  c.reaction_time = reaction_time(training);
  std::vector<Samples> train, test;
  double depth = 0, speed = 0;
  for (const Demonstration* d : training) {
    train.push_back(samples(*d, c.reaction_time));
    for (const Sample& s : train.back()) {
      depth = std::max(depth, s.depth);
      speed = std::max(speed, s.velocity.norm());
    }
    c.rows += train.back().size();
    c.episodes.push_back(d->file);
  }
  for (const Demonstration* d : testing) {
    test.push_back(samples(*d, c.reaction_time));
    c.held_out.push_back(d->file);
  }
  std::sort(c.episodes.begin(), c.episodes.end());
  std::sort(c.held_out.begin(), c.held_out.end());
  refuse_uninformative(train);
  if (!(depth > 0) || !(speed > 0))
    throw BadInput("the demonstrations tell nothing about insertion: the hand never went in");

  const double scale = set.speed_scale;
  const Units units(scale, depth);
  Solution best;
  for (const double ramp : {0.2, 2.0})
    for (const double length : {0.05, 0.5}) {
      const Gains start = {1, ramp, 1.1, length, 0.1, 0.01, 0.5, 0.5, 0, 0, 0, 0};
      const Solution s = solve(train, units, scale, start, true);
      if (s.cost < best.cost) best = s;
    }
  if (!std::isfinite(best.cost))
    throw BadInput("the fit did not converge from any start: " + best.summary);

  // Bounds slow the last digits down where the data hold a gain close to one; without them the
  // solution may be reached, and is kept if it respects them.
  const Solution free = solve(train, units, scale, best.scaled, false);
  if (free.cost < best.cost && within_bounds(free.scaled)) best = free;

  Gains gains;
  const Gains half = half_widths(train, units, scale, best.scaled);
  for (std::size_t i = 0; i < kGains; ++i) {
    gains[i] = best.scaled[i] * units.value[i];
    c.gains[i] = {gains[i], gains[i] - half[i] * units.value[i],
                  gains[i] + half[i] * units.value[i]};
  }
  c.scenes = set.scenes;
  c.seed = seed;
  c.residual = root_mean_square(train, gains);
  c.held_out_residual = root_mean_square(test, gains);
  report.summary = best.summary;
  report.iterations = best.iterations;
  double variance = 0, n = 0;
  Vector3d mean = Vector3d::Zero();
  for (const Samples& episode : train)
    for (const Sample& s : episode) mean += s.velocity, n += 1;
  mean /= n;
  for (const Samples& episode : train)
    for (const Sample& s : episode) variance += (s.velocity - mean).squaredNorm();
  report.explained = 1 - c.residual * c.residual * n / variance;
  return report;
}

}  // namespace ferrule
