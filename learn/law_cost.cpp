#include "learn/law_cost.hpp"

#include <ceres/cost_function.h>
#include <ceres/jet.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <optional>

namespace ferrule {
namespace {

// One size for all laws, each with the derivatives to its own gains in front: five sizes compile
// for most of a minute.
using Jet = ceres::Jet<double, 16>;

template <LawKind kind>
struct RowError {
  static constexpr int kCount = static_cast<int>(gain_table(kind).size());
  static_assert(kCount <= Jet::DIMENSION);
  const Sample& sample;
  const LawUnits& units;

  template <class T>
  bool operator()(const T* scaled, T* error) const {
    T gain[kCount];
    for (std::size_t i = 0; i < kCount; ++i) {
      gain[i] = scaled[i] * units.gains[i];
      if (gain_table(kind)[i].range == Gain::positive && !(gain[i] > 0.0)) return false;
    }
    const Eigen::Matrix<T, 3, 1> v = law_velocity(kind, gain, sample);
    for (int axis = 0; axis < 3; ++axis)
      error[axis] = (v[axis] - sample.velocity[axis]) / units.speed;
    return true;
  }

  bool with_derivatives(const double* scaled, double* error, double* jacobian) const {
    Jet x[kCount], e[3];
    for (int i = 0; i < kCount; ++i) x[i] = Jet(scaled[i], i);
    if (!(*this)(x, e)) return false;
    for (int axis = 0; axis < 3; ++axis) {
      error[axis] = e[axis].a;
      jacobian = std::copy_n(e[axis].v.data(), kCount, jacobian);
    }
    return true;
  }
};

template <LawKind kind>
bool error_of(const Sample& sample, const LawUnits& units, const double* scaled, double* error,
              double* jacobian) {
  const RowError<kind> row{sample, units};
  return jacobian ? row.with_derivatives(scaled, error, jacobian) : row(scaled, error);
}

// Of one row, and its derivatives (3, n) to the scaled gains, row by row, where `jacobian` is not
// null. False where the gains are of no law.
bool row_error(LawKind kind, const Sample& sample, const LawUnits& units, const double* scaled,
               double* error, double* jacobian) {
  switch (kind) {
    case LawKind::linear:
      return error_of<LawKind::linear>(sample, units, scaled, error, jacobian);
    case LawKind::phased:
      return error_of<LawKind::phased>(sample, units, scaled, error, jacobian);
    case LawKind::guarded:
      return error_of<LawKind::guarded>(sample, units, scaled, error, jacobian);
    case LawKind::saturated:
      return error_of<LawKind::saturated>(sample, units, scaled, error, jacobian);
    case LawKind::insertion:
      break;
  }
  return error_of<LawKind::insertion>(sample, units, scaled, error, jacobian);
}

// Of an episode's rows, weighted.
struct Weighted {
  Eigen::MatrixXd triangle;  // R: (n + 1, n + 1)
  double beyond;             // sum of rho_i - w_i |r_i|^2
};

// Empty where the gains are of no law.
std::optional<Weighted> weighted(LawKind kind, const Samples& episode, const LawUnits& units,
                                 const double* scaled) {
  constexpr Eigen::Index kRows = 64;  // at a time, below the triangle so far
  const auto n = static_cast<Eigen::Index>(units.gains.size());
  Eigen::MatrixXd block = Eigen::MatrixXd::Zero(n + 1 + 3 * kRows, n + 1);
  Eigen::Index filled = n + 1;
  const auto fold = [&] {
    const Eigen::HouseholderQR<Eigen::Ref<Eigen::MatrixXd>> in_place(block);
    block.triangularView<Eigen::StrictlyLower>().setZero();
    filled = n + 1;
  };
  Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor> jacobian(3, n);
  Eigen::Vector3d error;
  double beyond = 0;
  for (const Sample& sample : episode) {
    if (!row_error(kind, sample, units, scaled, error.data(), jacobian.data())) return std::nullopt;
    const double size = error.norm(), root = std::sqrt(huber_weight(size, kVelocityHuber));
    beyond += kVelocityHuber * std::max(0.0, size - kVelocityHuber);
    block.middleRows<3>(filled) << root * jacobian, root * error;
    filled += 3;
    if (filled == block.rows()) fold();
  }
  fold();
  return Weighted{block.topRows(n + 1), beyond};
}

class EpisodeCost : public ceres::CostFunction {
 public:
  EpisodeCost(LawKind kind, const Samples& episode, const LawUnits& units)
      : kind_(kind), episode_(episode), units_(units) {
    set_num_residuals(gains() + 2);
    mutable_parameter_block_sizes()->push_back(gains());
  }

  bool Evaluate(const double* const* parameters, double* residuals,
                double** jacobians) const override {
    Eigen::Map<Eigen::VectorXd> residual(residuals, gains() + 2);
    if (!jacobians || !jacobians[0]) {
      const std::optional<double> loss = sum_of_losses(parameters[0]);
      residual.setZero();
      residual[0] = std::sqrt(loss.value_or(0));
      return loss.has_value();
    }
    const std::optional<Weighted> w = weighted(kind_, episode_, units_, parameters[0]);
    if (!w) return false;
    residual << w->triangle.rightCols<1>(), std::sqrt(w->beyond);
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
        jacobians[0], gains() + 2, gains())
        << w->triangle.leftCols(gains()),
        Eigen::RowVectorXd::Zero(gains());
    return true;
  }

 private:
  int gains() const { return static_cast<int>(units_.gains.size()); }

  std::optional<double> sum_of_losses(const double* scaled) const {
    constexpr double h = kVelocityHuber;
    double sum = 0;
    Eigen::Vector3d error;
    for (const Sample& sample : episode_) {
      if (!row_error(kind_, sample, units_, scaled, error.data(), nullptr)) return std::nullopt;
      const double size = error.norm();
      sum += size > h ? h * (2 * size - h) : size * size;
    }
    return sum;
  }

  LawKind kind_;
  const Samples& episode_;
  const LawUnits& units_;
};

}  // namespace

std::unique_ptr<ceres::CostFunction> episode_cost(LawKind kind, const Samples& episode,
                                                  const LawUnits& units) {
  return std::make_unique<EpisodeCost>(kind, episode, units);
}

EpisodeSums episode_sums(LawKind kind, const Samples& episode, const LawUnits& units,
                         const std::vector<double>& scaled) {
  const auto n = static_cast<Eigen::Index>(scaled.size());
  const Eigen::MatrixXd r = weighted(kind, episode, units, scaled.data()).value().triangle;
  EpisodeSums sums(n);
  sums.information = r.leftCols(n).transpose() * r.leftCols(n);
  sums.score = r.leftCols(n).transpose() * r.col(n);
  return sums;
}

}  // namespace ferrule
