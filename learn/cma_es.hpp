// Minimises a function of a few to a few tens of numbers whose values are noisy and have no
// derivatives: evolution with covariance matrix adaptation (Hansen, The CMA evolution strategy: a
// tutorial, 2016, arXiv:1604.00772, with its default parameters and weights of the better half).
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace ferrule {

class CmaEs {
 public:
  // Begins around `mean`, of at least one number, with the standard deviation `sigma` > 0 of each;
  // scale the numbers so that they are alike. `population` >= 4 candidates in a generation;
  // default_population() where nothing speaks for more. The same seed takes the same way.
  CmaEs(Eigen::VectorXd mean, double sigma, int population, std::uint64_t seed);

  // 4 + 3 ln n, rounded down (table 1).
  static int default_population(Eigen::Index n);

  // The candidates of the next generation, by columns.
  const Eigen::MatrixXd& ask();
  // The values of those, in their order: only which is lower matters. Not finite: the worst.
  void tell(const Eigen::VectorXd& values);

  // The centre of the distribution: under noise better than the best candidate.
  const Eigen::VectorXd& mean() const noexcept { return mean_; }
  // Its largest standard deviation.
  double spread() const noexcept { return sigma_ * axes_.maxCoeff(); }

 private:
  void decompose();

  Eigen::Index n_;
  std::uint64_t seed_, generation_ = 0;
  Eigen::VectorXd weights_;
  double mu_eff_, c_sigma_, d_sigma_, c_c_, c_1_, c_mu_, chi_;  // as in the tutorial

  Eigen::VectorXd mean_, p_sigma_, p_c_;
  double sigma_;
  Eigen::MatrixXd covariance_, basis_, steps_, candidates_;  // C = B D^2 B^T; y of (39); x of (40)
  Eigen::VectorXd axes_;                                     // D
};

}  // namespace ferrule
