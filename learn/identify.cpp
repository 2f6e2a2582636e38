#include "learn/identify.hpp"

#include <ceres/ceres.h>
#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>

#include "controller/statistics.hpp"
#include "learn/intervals.hpp"
#include "learn/replays.hpp"
#include "sim/base/random.hpp"

namespace ferrule {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr std::size_t kFewestRecordings = 3;
constexpr double kForceHuber = 0.005;        // of the force limit
constexpr double kDifference = 0.02;         // of numeric differences, in the coordinate
constexpr double kJump = 0.5 * kForceHuber;  // of the second difference: no derivative there
constexpr double kRange = SceneNumber::kRange;
constexpr double kGood = 2e-3;            // of the force limit, to which the fit is good
constexpr double kLeftOut = 0.01;         // of the rows, those that differ most
constexpr double kFalseAlarm = 1e-3;      // of the noise alone, to exceed the limit
constexpr double kNoChange = 1e-6;        // change of force, of the force limit
constexpr double kReplaceable = 0.99;     // correlation of two that stand for each other
constexpr std::size_t kRandomPoints = 6;  // per parameter
constexpr std::size_t kStarts = 3;

// Half the sum of squares of all rows times this is the sum of Huber's loss.
double robust_scale(const Wrench& row) noexcept {
  const double size = row.norm();
  return size > kForceHuber ? std::sqrt(kForceHuber * (2 * size - kForceHuber)) / size : 1;
}

void make_robust(MatrixXd& residuals) {
  for (Eigen::Index n = 0; n < residuals.rows(); n += 5) {
    const Wrench row = residuals.block<5, 1>(n, 0);
    residuals.block<5, 1>(n, 0) = robust_scale(row) * row;
  }
}

// Columns: x, then x + and x - the step in each coordinate that is `free`.
MatrixXd difference_points(const VectorXd& x, const std::vector<Eigen::Index>& free) {
  MatrixXd points = x.replicate(1, 1 + 2 * static_cast<Eigen::Index>(free.size()));
  for (std::size_t k = 0; k < free.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(1 + 2 * k);
    points(free[k], column) += kDifference;
    points(free[k], column + 1) -= kDifference;
  }
  return points;
}

MatrixXd central_differences(const MatrixXd& residuals) {
  MatrixXd jacobian(residuals.rows(), (residuals.cols() - 1) / 2);
  for (Eigen::Index k = 0; k < jacobian.cols(); ++k)
    jacobian.col(k) = (residuals.col(1 + 2 * k) - residuals.col(2 + 2 * k)) / (2 * kDifference);
  return jacobian;
}

// Does row n, of the points of difference_points, jump within a step of parameter k?
bool jumps(const MatrixXd& residuals, Eigen::Index k, Eigen::Index n) {
  const auto at = [&](Eigen::Index column) { return residuals.block<5, 1>(n, column); };
  return (at(1 + 2 * k) + at(2 + 2 * k) - 2 * at(0)).norm() > kJump;
}

// Rows that jump within a step have no derivative: they get zero. Left in, the few of them would
// outweigh all others in the intervals and feign knowledge of the parameters.
void leave_out_jumps(const MatrixXd& residuals, MatrixXd& jacobian) {
  for (Eigen::Index k = 0; k < jacobian.cols(); ++k)
    for (Eigen::Index n = 0; n < residuals.rows(); n += 5)
      if (jumps(residuals, k, n)) jacobian.block<5, 1>(n, k).setZero();
}

// All residuals as one block for Ceres, so that the sum does not depend on the number of threads.
// Derivatives are those of the coarse replay, which are as good to step by and cost a fraction.
class ReplayCost : public ceres::CostFunction {
 public:
  ReplayCost(const Replays& replays, const VectorXd& x, const std::vector<Eigen::Index>& free,
             Replays::Steps steps)
      : replays_(replays), x_(x), free_(free), steps_(steps) {
    set_num_residuals(static_cast<int>(5 * replays.rows()));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(free.size()));
  }

  bool Evaluate(const double* const* parameters, double* residuals,
                double** jacobians) const override {
    const auto n = static_cast<Eigen::Index>(free_.size());
    VectorXd x = x_;
    x(free_) = Eigen::Map<const VectorXd>(parameters[0], n);
    MatrixXd all, around;
    if (!replays_.residuals(x, steps_, all)) return false;
    if (jacobians && jacobians[0]) {
      if (!replays_.residuals(difference_points(x, free_), Replays::coarse, around)) return false;
      MatrixXd jacobian = central_differences(around);
      // So that its product with the scaled residuals is the gradient of Huber's loss.
      for (Eigen::Index row = 0; row < all.rows(); row += 5) {
        const Wrench error = all.block<5, 1>(row, 0);
        jacobian.middleRows<5>(row) *=
            huber_weight(error.norm(), kForceHuber) / robust_scale(error);
      }
      Eigen::Map<RowMajor>(jacobians[0], all.rows(), n) = jacobian;
    }
    make_robust(all);
    Eigen::Map<VectorXd>(residuals, all.rows()) = all.col(0);
    return true;
  }

 private:
  const Replays& replays_;
  const VectorXd& x_;
  const std::vector<Eigen::Index>& free_;
  Replays::Steps steps_;
};

struct Solution {
  VectorXd x;
  double cost;
};

constexpr int kCoarseIterations = 10, kIterations = 25;  // at most

// How far it is, and whether it goes on.
class Going : public ceres::IterationCallback {
 public:
  Going(const IdentifyProgress& progress, std::size_t all) : progress_(progress), all_(all) {}

  bool stopped() const { return stopped_; }
  // After a step; false: no more of them.
  bool step() {
    stopped_ |= progress_ && !progress_(std::min(++done_, all_), all_);
    return !stopped_;
  }
  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
    return step() ? ceres::SOLVER_CONTINUE : ceres::SOLVER_TERMINATE_SUCCESSFULLY;
  }

 private:
  const IdentifyProgress& progress_;
  std::size_t done_ = 0, all_;
  bool stopped_ = false;
};

Solution solve(const Replays& replays, const VectorXd& start, const std::vector<Eigen::Index>& free,
               Replays::Steps steps, Going& going) {
  std::vector<double> at;
  for (const Eigen::Index i : free) at.push_back(start[i]);
  ceres::Problem problem;
  problem.AddResidualBlock(new ReplayCost(replays, start, free, steps), nullptr, at.data());
  for (int i = 0; i < static_cast<int>(free.size()); ++i) {
    problem.SetParameterLowerBound(at.data(), i, -kRange);
    problem.SetParameterUpperBound(at.data(), i, kRange);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  const bool coarse = steps == Replays::coarse;
  options.max_num_iterations = coarse ? kCoarseIterations : kIterations;
  options.callbacks.push_back(&going);
  options.function_tolerance = coarse ? 1e-3 : 1e-5;
  options.parameter_tolerance = 1e-5;
  options.gradient_tolerance = 1e-14;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  Solution s{start, summary.IsSolutionUsable() ? summary.final_cost : INFINITY};
  for (std::size_t k = 0; k < free.size(); ++k) s.x[free[k]] = at[k];
  return s;
}

// Parameters that move some force between their bounds.
std::vector<Eigen::Index> free_parameters(const Replays& replays, Eigen::Index parameters) {
  std::vector<Eigen::Index> free;
  for (Eigen::Index i = 0; i < parameters; ++i) {
    MatrixXd points = MatrixXd::Zero(parameters, 5), all;
    points.row(i) << 0, -kRange, -kDifference, kDifference, kRange;
    // The bounds themselves may not go with the other parameters.
    if (!replays.residuals(points, Replays::coarse, all)) {
      points.row(i) << 0, -2 * kDifference, -kDifference, kDifference, 2 * kDifference;
      if (!replays.residuals(points, Replays::coarse, all)) continue;
    }
    const MatrixXd change = all.rightCols(4).colwise() - all.col(0);
    if (change.cwiseAbs().maxCoeff() > kNoChange) free.push_back(i);
  }
  return free;
}

// The start, and the best of random points within the bounds.
std::vector<VectorXd> starts(const Replays& replays, const std::vector<Eigen::Index>& free,
                             Eigen::Index parameters, std::uint64_t seed, Going& going) {
  RandomStream random(seed, 0, Draw::split);
  std::vector<Solution> tried;
  for (std::size_t k = 0; k < kRandomPoints * free.size() && going.step(); ++k) {
    VectorXd x = VectorXd::Zero(parameters);
    for (const Eigen::Index i : free) x[i] = kRange * (2 * random.uniform() - 1);
    MatrixXd residual;
    if (!replays.residuals(x, Replays::coarse, residual)) continue;
    make_robust(residual);
    tried.push_back({x, residual.squaredNorm()});
  }
  std::stable_sort(tried.begin(), tried.end(),
                   [](const Solution& a, const Solution& b) { return a.cost < b.cost; });
  std::vector<VectorXd> chosen = {VectorXd::Zero(parameters)};
  for (std::size_t k = 0; k < tried.size() && chosen.size() < kStarts; ++k)
    chosen.push_back(tried[k].x);
  return chosen;
}

// Of the free parameters at a solution, `all` being the residuals at its difference_points.
Precision precision_at(const Replays& replays, std::size_t recordings, const MatrixXd& all,
                       const std::vector<bool>& fixed) {
  MatrixXd jacobian = central_differences(all);
  leave_out_jumps(all, jacobian);
  std::vector<EpisodeSums> sums;
  for (std::size_t r = 0; r < recordings; ++r) {
    sums.emplace_back(jacobian.cols());
    const auto [first, count] = replays.rows_of(r);
    for (Eigen::Index n = 5 * first; n < 5 * (first + count); n += 5) {
      const auto j = jacobian.middleRows<5>(n);
      const Wrench error = all.block<5, 1>(n, 0);
      const double weight = huber_weight(error.norm(), kForceHuber);
      sums.back().information += weight * j.transpose() * j;
      sums.back().score += weight * j.transpose() * error;
    }
  }
  return precision(sums, fixed);
}

// White noise of the forces [of the limit]: of what changes from one row to the next, by its median.
double white_noise(const Replays& replays, std::size_t recordings, const VectorXd& residuals) {
  std::vector<double> changes;
  for (std::size_t r = 0; r < recordings; ++r) {
    const auto [first, count] = replays.rows_of(r);
    for (Eigen::Index n = first + 1; n < first + count; ++n)
      for (Eigen::Index i = 0; i < 3; ++i)
        changes.push_back(std::abs(residuals[5 * n + i] - residuals[5 * (n - 1) + i]));
  }
  if (changes.empty()) return 0;
  return quantile(changes, 0.5) / (0.6745 * std::sqrt(2.0));  // median of |x|, x normal
}

// Sets misfit, its limit, and noise; `all` as of precision_at.
void hold_against_noise(const Replays& replays, std::size_t recordings, const Scene& scene,
                        const MatrixXd& all, Identification& result) {
  VectorXd sigma = replays.sensor_noise() / replays.unit();
  const double white = replays.white_sensor_noise() / replays.unit();
  const VectorXd lasting = sigma.array().square() - white * white;  // 0 of an ideal sensor
  if (sigma.isZero(0)) sigma.setConstant(white_noise(replays, recordings, all.col(0)));
  sigma = sigma.array().square() + kGood * kGood;  // squared
  result.noise = replays.unit() * std::sqrt(3 * sigma.mean());
  std::vector<double> squares;
  double correlated = 0;  // sum of rho^2 over all pairs of rows
  for (std::size_t r = 0; r < recordings; ++r) {
    const auto [first, count] = replays.rows_of(r);
    std::vector<Eigen::Index> smooth;
    for (Eigen::Index n = first; n < first + count; ++n) {
      bool jump = false;
      for (Eigen::Index k = 0; k < all.cols() / 2; ++k) jump |= jumps(all, k, 5 * n);
      if (!jump) smooth.push_back(n);
    }
    Eigen::Vector3d bias = Eigen::Vector3d::Zero();
    if (scene.sensor.biased())
      for (const Eigen::Index n : smooth)
        bias += all.block<3, 1>(5 * n, 0) / static_cast<double>(smooth.size());
    double shares = 0;
    for (const Eigen::Index n : smooth) {
      squares.push_back((all.block<3, 1>(5 * n, 0) - bias).squaredNorm() / sigma[n]);
      const double share = lasting[n] / sigma[n];
      shares += share;
      correlated += 1 - share * share;
    }
    correlated += shares * shares;
  }
  const double independent = static_cast<double>(squares.size()) / correlated;  // of each row
  std::sort(squares.begin(), squares.end());
  squares.resize(static_cast<std::size_t>((1 - kLeftOut) * static_cast<double>(squares.size())));
  double sum = 0;
  for (const double square : squares) sum += square;
  const double freedom =
      3 * static_cast<double>(squares.size()) - static_cast<double>(result.parameters.size());
  result.misfit = result.misfit_limit = NAN;
  if (!(freedom > 0)) return;
  result.misfit = std::sqrt(sum / freedom);
  const boost::math::chi_squared noise(independent * freedom);
  result.misfit_limit =
      std::sqrt(boost::math::quantile(complement(noise, kFalseAlarm)) / (independent * freedom));
}

double force_difference(const Replays& replays, const VectorXd& x) {
  MatrixXd residual;
  if (!replays.residuals(x, Replays::recorded, residual)) return NAN;
  double sum = 0;
  for (Eigen::Index n = 0; n < residual.rows(); n += 5)
    sum += residual.block<3, 1>(n, 0).squaredNorm();
  return replays.unit() * std::sqrt(sum / static_cast<double>(replays.rows()));
}

IdentifiedParameter open_parameter(const SceneNumber& c) {
  return {c.key(), Told::open, c.start(), c.value(-kRange), c.value(kRange), NAN, NAN, NAN};
}

IdentifiedParameter identified(const SceneNumber& c, double x, double half, bool at_bound) {
  IdentifiedParameter p = open_parameter(c);
  if (at_bound) {
    p.told = Told::at_bound;
    p.value = c.value(x);
  } else if (std::isfinite(half) && (x - half > -kRange || x + half < kRange)) {
    p.told = Told::fitted;
    p.value = c.value(x);
    if (x - half > -kRange) p.low = c.value(x - half);
    if (x + half < kRange) p.high = c.value(x + half);
  }
  return p;
}

}  // namespace

const char* name(Told told) noexcept {
  constexpr std::array names = {"fitted", "at_bound", "open"};
  return names[static_cast<std::size_t>(told)];
}

Identification identify(const std::vector<Recording>& recordings, const Scene& scene,
                        const std::vector<std::string>& keys, std::uint64_t seed,
                        const IdentifyProgress& progress) {
  if (recordings.size() < kFewestRecordings)
    throw BadInput(fmt::format("too few episodes with rows: {}; {} are needed", recordings.size(),
                               kFewestRecordings));
  std::vector<SceneNumber> numbers;
  for (const std::string& key : keys) {
    if (std::count(keys.begin(), keys.end(), key) > 1)
      throw BadInput("parameter " + key + ": is there twice");
    numbers.emplace_back(scene, key);
  }
  const auto parameters = static_cast<Eigen::Index>(keys.size());
  const Replays replays(recordings, scene, numbers);
  const std::vector<Eigen::Index> free = free_parameters(replays, parameters);

  Going going(progress, kRandomPoints * free.size() + kStarts * kCoarseIterations + kIterations);
  Solution best{VectorXd::Zero(parameters), INFINITY};
  if (!free.empty()) {
    for (const VectorXd& start : starts(replays, free, parameters, seed, going)) {
      if (going.stopped()) break;
      Solution s = solve(replays, start, free, Replays::coarse, going);
      if (s.cost < best.cost) best = std::move(s);
    }
    if (!going.stopped()) best = solve(replays, best.x, free, Replays::recorded, going);
    if (!std::isfinite(best.cost)) throw BadInput("the identification did not converge");
  }

  Identification result;
  result.partial = going.stopped();
  result.rows = static_cast<std::size_t>(replays.rows());
  result.residual_start = force_difference(replays, VectorXd::Zero(parameters));
  result.residual = force_difference(replays, best.x);
  result.correlation = MatrixXd::Zero(parameters, parameters);
  for (const SceneNumber& c : numbers) result.parameters.push_back(open_parameter(c));
  MatrixXd around;
  if (!replays.residuals(difference_points(best.x, free), Replays::recorded, around))
    throw BadInput("the solution is at the edge of what the scene allows");
  hold_against_noise(replays, recordings.size(), scene, around, result);
  if (free.empty()) return result;

  std::vector<bool> at_bound;
  for (const Eigen::Index i : free) at_bound.push_back(std::abs(best.x[i]) > kRange - kDifference);
  const Precision p = precision_at(replays, recordings.size(), around, at_bound);
  const double wider = result.fits() ? 1 : result.misfit;
  for (std::size_t k = 0; k < free.size(); ++k) {
    const auto i = static_cast<std::size_t>(free[k]);
    result.parameters[i] =
        identified(numbers[i], best.x[free[k]], wider * p.half_width[static_cast<Eigen::Index>(k)],
                   at_bound[k]);
  }
  result.correlation(free, free) = p.correlation;
  for (Eigen::Index i = 0; i < parameters; ++i)
    for (Eigen::Index j = 0; j < parameters; ++j)
      if (i != j && std::abs(result.correlation(i, j)) > kReplaceable)
        result.parameters[static_cast<std::size_t>(i)] =
            open_parameter(numbers[static_cast<std::size_t>(i)]);
  return result;
}

}  // namespace ferrule
