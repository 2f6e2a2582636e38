#include "learn/cma_es.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "sim/base/elementary.hpp"
#include "sim/base/random.hpp"

namespace ferrule {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

int CmaEs::default_population(Index n) {
  return 4 + static_cast<int>(3 * elementary::log(static_cast<double>(n)));
}

CmaEs::CmaEs(VectorXd mean, double sigma, int population, std::uint64_t seed)
    : n_(mean.size()),
      seed_(seed),
      weights_(population / 2),
      mean_(std::move(mean)),
      p_sigma_(VectorXd::Zero(n_)),
      p_c_(VectorXd::Zero(n_)),
      sigma_(sigma),
      covariance_(MatrixXd::Identity(n_, n_)),
      steps_(n_, population) {
  for (Index i = 0; i < weights_.size(); ++i)
    weights_[i] =
        elementary::log(0.5 * (population + 1)) - elementary::log(static_cast<double>(i + 1));
  weights_ /= weights_.sum();
  mu_eff_ = 1 / weights_.squaredNorm();
  const auto n = static_cast<double>(n_);
  c_sigma_ = (mu_eff_ + 2) / (n + mu_eff_ + 5);
  d_sigma_ = 1 + 2 * std::max(0.0, std::sqrt((mu_eff_ - 1) / (n + 1)) - 1) + c_sigma_;
  c_c_ = (4 + mu_eff_ / n) / (n + 4 + 2 * mu_eff_ / n);
  c_1_ = 2 / ((n + 1.3) * (n + 1.3) + mu_eff_);
  c_mu_ = std::min(1 - c_1_, 2 * (mu_eff_ - 2 + 1 / mu_eff_) / ((n + 2) * (n + 2) + mu_eff_));
  chi_ = std::sqrt(n) * (1 - 1 / (4 * n) + 1 / (21 * n * n));
  decompose();
}

void CmaEs::decompose() {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(covariance_);
  basis_ = solver.eigenvectors();
  axes_ = solver.eigenvalues().cwiseMax(1e-30).cwiseSqrt();
}

const MatrixXd& CmaEs::ask() {
  RandomStream random(seed_, generation_, "cma_es");
  for (Index k = 0; k < steps_.cols(); ++k) {
    for (Index i = 0; i < n_; ++i) steps_(i, k) = random.normal();
    steps_.col(k) = basis_ * axes_.cwiseProduct(steps_.col(k));
  }
  candidates_ = (sigma_ * steps_).colwise() + mean_;
  return candidates_;
}

void CmaEs::tell(const VectorXd& values) {
  std::vector<Index> order(static_cast<std::size_t>(values.size()));
  std::iota(order.begin(), order.end(), Index{0});
  const auto worth = [&](Index k) { return std::isfinite(values[k]) ? values[k] : INFINITY; };
  std::stable_sort(order.begin(), order.end(),
                   [&](Index a, Index b) { return worth(a) < worth(b); });

  MatrixXd better(n_, weights_.size());
  for (Index i = 0; i < weights_.size(); ++i)
    better.col(i) = steps_.col(order[static_cast<std::size_t>(i)]);
  const VectorXd step = better * weights_;  // (41)
  mean_ += sigma_ * step;                   // (42)
  ++generation_;

  const VectorXd white = basis_ * (basis_.transpose() * step).cwiseQuotient(axes_);
  p_sigma_ =
      (1 - c_sigma_) * p_sigma_ + std::sqrt(c_sigma_ * (2 - c_sigma_) * mu_eff_) * white;  // (43)
  const double length = p_sigma_.norm();
  sigma_ *= elementary::exp(c_sigma_ / d_sigma_ * (length / chi_ - 1));  // (44)

  const double forgotten =
      elementary::exp(2 * static_cast<double>(generation_) * elementary::log1p(-c_sigma_));
  const double remembered = std::sqrt(1 - forgotten);
  const auto n = static_cast<double>(n_);
  const double h = length / remembered < (1.4 + 2 / (n + 1)) * chi_ ? 1 : 0;
  p_c_ = (1 - c_c_) * p_c_ + h * std::sqrt(c_c_ * (2 - c_c_) * mu_eff_) * step;  // (45)
  covariance_ = (1 - c_1_ - c_mu_ + c_1_ * (1 - h) * c_c_ * (2 - c_c_)) * covariance_ +
                c_1_ * p_c_ * p_c_.transpose() +
                c_mu_ * better * weights_.asDiagonal() * better.transpose();  // (47)
  decompose();
}

}  // namespace ferrule
