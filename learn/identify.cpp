#include "learn/identify.hpp"

#include <ceres/ceres.h>
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "learn/intervals.hpp"
#include "sim/random.hpp"

namespace ferrule {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr std::size_t kFewestRecordings = 3;
constexpr double kEvery = 0.01;               // between rows compared [s]
constexpr double kHuber = 0.005;              // of the force limit
constexpr double kStep = 0.02;                // of numeric differences, in the coordinate
constexpr double kJump = 0.5 * kHuber;        // of the second difference: no derivative there
constexpr double kRange = 2.302585092994046;  // log(10): bound of the coordinate
constexpr double kNothing = 1e-6;             // change of force, of the force limit
constexpr double kReplaceable = 0.99;         // correlation of two that stand for each other
constexpr std::size_t kRandomPoints = 6;      // per parameter
constexpr std::size_t kStarts = 3;

Json::json_pointer pointer(const std::string& key) {
  if (key.find_first_of("~/") != key.npos)
    throw BadInput("parameter " + key + ": must be a dotted key of the scene");
  std::string path = "/" + key;
  std::replace(path.begin(), path.end(), '.', '/');
  return Json::json_pointer(path);
}

// A number of the scene on the scale it is moved on; coordinate 0 is its start.
class Coordinate {
 public:
  Coordinate(const Scene& scene, const std::string& key) : key_(key), at_(pointer(key)) {
    if (!scene.document.contains(at_) || !scene.document[at_].is_number())
      throw BadInput(
          fmt::format("parameter {}: there is no such number in the scene {}", key, scene.name));
    start_ = scene.document[at_];
    const auto allowed = [&, document = scene.document](double value) mutable {
      document[at_] = value;
      try {
        parse_scene(document, scene.name);
        return true;
      } catch (const BadInput&) {
        return false;
      }
    };
    below_ = edge(allowed, -1);
    above_ = edge(allowed, 1);
    const double room = 1e-9 * std::max(std::abs(start_), 1e-300);
    if (!(start_ - below_ > room) || !(above_ - start_ > room))
      throw BadInput(fmt::format("parameter {}: cannot be varied from {}", key, start_));
  }

  const std::string& key() const { return key_; }
  const Json::json_pointer& at() const { return at_; }
  double start() const { return start_; }

  double value(double x) const {
    const bool low = std::isfinite(below_), high = std::isfinite(above_);
    if (low && high) {
      const double ratio = (start_ - below_) / (above_ - start_) * std::exp(x);
      return (below_ + above_ * ratio) / (1 + ratio);
    }
    if (low) return below_ + (start_ - below_) * std::exp(x);
    if (high) return above_ - (above_ - start_) * std::exp(-x);
    return start_ + (start_ != 0 ? std::abs(start_) : 1) * x;
  }

 private:
  // Where values from the start on in direction `sign` cease to be allowed; infinite if not within
  // a factor of a thousand, and 0 if not that near to it: farther than a parameter is moved.
  double edge(const std::function<bool(double)>& allowed, double sign) const {
    const double size = std::max(std::abs(start_), 1e-3);
    if (sign * start_ < 0 && allowed(1e-3 * start_) && !allowed(-1e-3 * start_)) return 0;
    double inside = start_, outside = start_ + sign * 1e3 * size;
    if (allowed(outside)) return sign * INFINITY;
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (inside + outside);
      (allowed(middle) ? inside : outside) = middle;
    }
    return inside;
  }

  std::string key_;
  Json::json_pointer at_;
  double start_, below_, above_;
};

// The recordings replayed in scenes with other parameters.
class Replays {
 public:
  Replays(const std::vector<Recording>& recordings, const Scene& scene,
          const std::vector<Coordinate>& coordinates)
      : recordings_(recordings), scene_(scene), coordinates_(coordinates) {
    const double force = scene.limits.force, moment = force * scene.world.holder.tilt_length;
    unit_ << force, force, force, moment, moment;
    for (const Recording& r : recordings_) {
      first_.push_back(rows_);
      rows_ += (r.hand.rows() - 1) / stride(r) + 1;
    }
  }

  Eigen::Index rows() const { return rows_; }
  double unit() const { return unit_[0]; }
  // Of a recording: first row, and how many.
  std::pair<Eigen::Index, Eigen::Index> rows_of(std::size_t recording) const {
    const Eigen::Index end = recording + 1 < first_.size() ? first_[recording + 1] : rows_;
    return {first_[recording], end - first_[recording]};
  }

  // Residuals, 5 per row, one column per point (column of `points`); false if a point is not a
  // scene. `coarse`: in steps of 10 ms.
  bool residuals(const MatrixXd& points, bool coarse, MatrixXd& result) const {
    std::vector<World> worlds;
    for (Eigen::Index p = 0; p < points.cols(); ++p) {
      Json document = scene_.document;
      for (std::size_t i = 0; i < coordinates_.size(); ++i)
        document[coordinates_[i].at()] =
            coordinates_[i].value(points(static_cast<Eigen::Index>(i), p));
      try {
        worlds.push_back(parse_scene(document, scene_.name).world);
      } catch (const BadInput&) {
        return false;
      }
    }
    result.resize(5 * rows_, points.cols());
    tbb::parallel_for(std::size_t{0}, worlds.size() * recordings_.size(), [&](std::size_t job) {
      const std::size_t p = job / recordings_.size(), r = job % recordings_.size();
      const auto column = static_cast<Eigen::Index>(p);
      replay(worlds[p], recordings_[r], coarse, result.col(column).data() + 5 * first_[r]);
    });
    return true;
  }

 private:
  static Eigen::Index stride(const Recording& r) {
    return std::max<Eigen::Index>(1, std::lround(kEvery / r.period));
  }

  void replay(const World& world, const Recording& r, bool coarse, double* residual) const {
    const Eigen::Index every = stride(r), by = coarse ? every : 1;
    State state = at_rest(world, r.hand.row(0).transpose() + world.holder.sag);
    for (Eigen::Index n = 0; n < r.hand.rows(); n += by) {
      const StepResult now = step(world, state, r.hand.row(n).transpose(),
                                  n == 0 ? 0.0 : static_cast<double>(by) * r.period);
      state = now.state;
      if (n % every != 0) continue;
      Eigen::Map<Wrench> error(residual + 5 * (n / every));
      error = (now.forces.holder - r.wrench.row(n).transpose()).cwiseQuotient(unit_);
    }
  }

  const std::vector<Recording>& recordings_;
  const Scene& scene_;
  const std::vector<Coordinate>& coordinates_;
  Wrench unit_;
  std::vector<Eigen::Index> first_;
  Eigen::Index rows_ = 0;
};

// Half the sum of squares of all rows times this is the sum of Huber's loss.
double robust_scale(const Wrench& row) noexcept {
  const double size = row.norm();
  return size > kHuber ? std::sqrt(kHuber * (2 * size - kHuber)) / size : 1;
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
    points(free[k], column) += kStep;
    points(free[k], column + 1) -= kStep;
  }
  return points;
}

MatrixXd central_differences(const MatrixXd& residuals) {
  MatrixXd jacobian(residuals.rows(), (residuals.cols() - 1) / 2);
  for (Eigen::Index k = 0; k < jacobian.cols(); ++k)
    jacobian.col(k) = (residuals.col(1 + 2 * k) - residuals.col(2 + 2 * k)) / (2 * kStep);
  return jacobian;
}

// Rows that jump within a step have no derivative: they get zero. Left in, the few of them would
// outweigh all others in the intervals and feign knowledge of the parameters.
void leave_out_jumps(const MatrixXd& residuals, MatrixXd& jacobian) {
  for (Eigen::Index k = 0; k < jacobian.cols(); ++k)
    for (Eigen::Index n = 0; n < residuals.rows(); n += 5) {
      const auto at = [&](Eigen::Index column) { return residuals.block<5, 1>(n, column); };
      if ((at(1 + 2 * k) + at(2 + 2 * k) - 2 * at(0)).norm() > kJump)
        jacobian.block<5, 1>(n, k).setZero();
    }
}

// All residuals as one block for Ceres, so that the sum does not depend on the number of threads.
class ReplayCost : public ceres::CostFunction {
 public:
  ReplayCost(const Replays& replays, const VectorXd& x, const std::vector<Eigen::Index>& free,
             bool coarse)
      : replays_(replays), x_(x), free_(free), coarse_(coarse) {
    set_num_residuals(static_cast<int>(5 * replays.rows()));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(free.size()));
  }

  bool Evaluate(const double* const* parameters, double* residuals,
                double** jacobians) const override {
    const auto n = static_cast<Eigen::Index>(free_.size());
    VectorXd x = x_;
    x(free_) = Eigen::Map<const VectorXd>(parameters[0], n);
    const bool differences = jacobians && jacobians[0];
    MatrixXd all;
    if (!replays_.residuals(differences ? difference_points(x, free_) : MatrixXd(x), coarse_, all))
      return false;
    if (differences) {
      MatrixXd jacobian = central_differences(all);
      // So that its product with the scaled residuals is the gradient of Huber's loss.
      for (Eigen::Index row = 0; row < all.rows(); row += 5) {
        const Wrench error = all.block<5, 1>(row, 0);
        jacobian.middleRows<5>(row) *= huber_weight(error.norm(), kHuber) / robust_scale(error);
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
  bool coarse_;
};

struct Solution {
  VectorXd x;
  double cost;
};

Solution solve(const Replays& replays, const VectorXd& start, const std::vector<Eigen::Index>& free,
               bool coarse) {
  std::vector<double> at;
  for (const Eigen::Index i : free) at.push_back(start[i]);
  ceres::Problem problem;
  problem.AddResidualBlock(new ReplayCost(replays, start, free, coarse), nullptr, at.data());
  for (int i = 0; i < static_cast<int>(free.size()); ++i) {
    problem.SetParameterLowerBound(at.data(), i, -kRange);
    problem.SetParameterUpperBound(at.data(), i, kRange);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = coarse ? 10 : 15;
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
    points.row(i) << 0, -kRange, -kStep, kStep, kRange;
    // The bounds themselves may not go with the other parameters.
    if (!replays.residuals(points, true, all)) {
      points.row(i) << 0, -2 * kStep, -kStep, kStep, 2 * kStep;
      if (!replays.residuals(points, true, all)) continue;
    }
    const MatrixXd change = all.rightCols(4).colwise() - all.col(0);
    if (change.cwiseAbs().maxCoeff() > kNothing) free.push_back(i);
  }
  return free;
}

// The start, and the best of random points within the bounds.
std::vector<VectorXd> starts(const Replays& replays, const std::vector<Eigen::Index>& free,
                             Eigen::Index parameters, std::uint64_t seed) {
  RandomStream random(seed, 0, Draw::split);
  std::vector<Solution> tried;
  for (std::size_t k = 0; k < kRandomPoints * free.size(); ++k) {
    VectorXd x = VectorXd::Zero(parameters);
    for (const Eigen::Index i : free) x[i] = kRange * (2 * random.uniform() - 1);
    MatrixXd residual;
    if (!replays.residuals(x, true, residual)) continue;
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

// At a solution; of the free parameters.
Precision precision_at(const Replays& replays, std::size_t recordings, const VectorXd& x,
                       const std::vector<Eigen::Index>& free, const std::vector<bool>& fixed) {
  MatrixXd all;
  if (!replays.residuals(difference_points(x, free), false, all))
    throw BadInput("the solution is at the edge of what the scene allows");
  MatrixXd jacobian = central_differences(all);
  leave_out_jumps(all, jacobian);
  std::vector<EpisodeSums> sums;
  for (std::size_t r = 0; r < recordings; ++r) {
    sums.emplace_back(static_cast<Eigen::Index>(free.size()));
    const auto [first, count] = replays.rows_of(r);
    for (Eigen::Index n = 5 * first; n < 5 * (first + count); n += 5) {
      const auto j = jacobian.middleRows<5>(n);
      const Wrench error = all.block<5, 1>(n, 0);
      const double weight = huber_weight(error.norm(), kHuber);
      sums.back().information += weight * j.transpose() * j;
      sums.back().score += weight * j.transpose() * error;
    }
  }
  return precision(sums, fixed);
}

double force_difference(const Replays& replays, const VectorXd& x) {
  MatrixXd residual;
  if (!replays.residuals(x, false, residual)) return NAN;
  double sum = 0;
  for (Eigen::Index n = 0; n < residual.rows(); n += 5)
    sum += residual.block<3, 1>(n, 0).squaredNorm();
  return replays.unit() * std::sqrt(sum / static_cast<double>(replays.rows()));
}

IdentifiedParameter open_parameter(const Coordinate& c) {
  return {c.key(), Told::open, c.start(), c.value(-kRange), c.value(kRange), NAN, NAN, NAN};
}

IdentifiedParameter identified(const Coordinate& c, double x, double half, bool at_bound) {
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

Recording recording(const Episode& episode, const std::string& file) {
  const Scaling scaling = scene_scaling(parse_scene(parse_json(episode.info.scene, file), file));
  Recording r{file, episode.info.period, episode.rows.middleCols<kPose>(kHandPose.begin),
              episode.rows.middleCols<kPose>(kHolder.begin)};
  for (Eigen::Index n = 0; n < r.hand.rows(); ++n)
    r.hand.row(n) = scaling.motion_to_tip(r.hand.row(n).transpose()).transpose();
  return r;
}

Identification identify(const std::vector<Recording>& recordings, const Scene& scene,
                        const std::vector<std::string>& keys, std::uint64_t seed) {
  if (recordings.size() < kFewestRecordings)
    throw BadInput(fmt::format("too few episodes with rows: {}; {} are needed", recordings.size(),
                               kFewestRecordings));
  std::vector<Coordinate> coordinates;
  for (const std::string& key : keys) {
    if (std::count(keys.begin(), keys.end(), key) > 1)
      throw BadInput("parameter " + key + ": is there twice");
    coordinates.emplace_back(scene, key);
  }
  const auto parameters = static_cast<Eigen::Index>(keys.size());
  const Replays replays(recordings, scene, coordinates);
  const std::vector<Eigen::Index> free = free_parameters(replays, parameters);

  Solution best{VectorXd::Zero(parameters), INFINITY};
  if (!free.empty()) {
    for (const VectorXd& start : starts(replays, free, parameters, seed)) {
      Solution s = solve(replays, start, free, true);
      if (s.cost < best.cost) best = std::move(s);
    }
    best = solve(replays, best.x, free, false);
    if (!std::isfinite(best.cost)) throw BadInput("the identification did not converge");
  }

  Identification result;
  result.rows = static_cast<std::size_t>(replays.rows());
  result.residual_start = force_difference(replays, VectorXd::Zero(parameters));
  result.residual = force_difference(replays, best.x);
  result.correlation = MatrixXd::Zero(parameters, parameters);
  for (const Coordinate& c : coordinates) result.parameters.push_back(open_parameter(c));
  if (free.empty()) return result;

  std::vector<bool> at_bound;
  for (const Eigen::Index i : free) at_bound.push_back(std::abs(best.x[i]) > kRange - kStep);
  const Precision p = precision_at(replays, recordings.size(), best.x, free, at_bound);
  for (std::size_t k = 0; k < free.size(); ++k) {
    const auto i = static_cast<std::size_t>(free[k]);
    result.parameters[i] = identified(coordinates[i], best.x[free[k]],
                                      p.half_width[static_cast<Eigen::Index>(k)], at_bound[k]);
  }
  result.correlation(free, free) = p.correlation;
  for (Eigen::Index i = 0; i < parameters; ++i)
    for (Eigen::Index j = 0; j < parameters; ++j)
      if (i != j && std::abs(result.correlation(i, j)) > kReplaceable)
        result.parameters[static_cast<std::size_t>(i)] =
            open_parameter(coordinates[static_cast<std::size_t>(i)]);
  return result;
}

}  // namespace ferrule
