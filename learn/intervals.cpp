#include "learn/intervals.hpp"

#include <Eigen/Eigenvalues>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

namespace ferrule {
namespace {

constexpr double kNothing = 1e-10;  // eigenvalue, of the information scaled to a unit diagonal
constexpr double kTouched = 1e-3;   // share of a parameter in an unobservable direction

}  // namespace

Precision precision(const std::vector<EpisodeSums>& episodes, const std::vector<bool>& fixed) {
  const auto all = static_cast<Eigen::Index>(fixed.size());
  EpisodeSums sum(all);
  Eigen::MatrixXd meat = Eigen::MatrixXd::Zero(all, all);
  for (const EpisodeSums& e : episodes) {
    sum.information += e.information;
    meat += e.score * e.score.transpose();
  }
  Precision result;
  result.half_width = Eigen::VectorXd::Constant(all, NAN);
  result.correlation = Eigen::MatrixXd::Zero(all, all);

  std::vector<Eigen::Index> open;
  for (Eigen::Index i = 0; i < all; ++i)
    if (!fixed[static_cast<std::size_t>(i)] && sum.information(i, i) > 0) open.push_back(i);
  if (open.empty()) return result;

  // Scaled to a unit diagonal, so that directions the data tell nothing of show as eigenvalues 0.
  const Eigen::MatrixXd b = sum.information(open, open), m = meat(open, open);
  const Eigen::VectorXd scale = b.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scale.asDiagonal() * b *
                                                             scale.asDiagonal());
  const auto n = static_cast<Eigen::Index>(open.size());
  Eigen::VectorXd inverse = Eigen::VectorXd::Zero(n), untold = Eigen::VectorXd::Zero(n);
  for (Eigen::Index k = 0; k < n; ++k)
    if (eigen.eigenvalues()[k] > kNothing)
      inverse[k] = 1 / eigen.eigenvalues()[k];
    else
      untold = untold.cwiseMax(eigen.eigenvectors().col(k).cwiseAbs());
  const Eigen::MatrixXd b_inverse = scale.asDiagonal() * eigen.eigenvectors() *
                                    inverse.asDiagonal() * eigen.eigenvectors().transpose() *
                                    scale.asDiagonal();
  const Eigen::MatrixXd covariance = b_inverse * m * b_inverse;
  const double g = static_cast<double>(episodes.size());
  const double t = quantile(boost::math::students_t(g - 1), 0.975) * std::sqrt(g / (g - 1));
  for (Eigen::Index i = 0; i < n; ++i) {
    if (untold[i] > kTouched) continue;
    const Eigen::Index at = open[static_cast<std::size_t>(i)];
    result.half_width[at] = t * std::sqrt(std::max(0.0, covariance(i, i)));
    for (Eigen::Index j = 0; j < n; ++j)
      if (untold[j] <= kTouched)
        result.correlation(at, open[static_cast<std::size_t>(j)]) =
            b_inverse(i, j) / std::sqrt(b_inverse(i, i) * b_inverse(j, j));
  }
  return result;
}

}  // namespace ferrule
