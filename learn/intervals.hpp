// 95 % intervals of parameters that minimise a (robust) sum of squares over episodes.
//
// The rows of one episode are not independent: what a hand or a sensor does at one moment lasts.
// Intervals that pretend they were are too narrow, so the covariance is the sandwich clustered by
// episode (Liang and Zeger 1986),
//   C = B^+ M B^+,   B = sum over rows of w J^T J,   M = sum over episodes of s s^T,
//   s = sum over an episode's rows of w J^T r,
// with J the Jacobian of the residuals r and w the weight of the robust loss. The half widths are
//   t sqrt(G / (G - 1)) sqrt(C_ii)
// with t Student's 97.5 % quantile of G - 1 degrees of freedom, G the number of episodes.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace ferrule {

// The sums of one episode.
struct EpisodeSums {
  Eigen::MatrixXd information;  // w J^T J
  Eigen::VectorXd score;        // w J^T r

  explicit EpisodeSums(Eigen::Index parameters)
      : information(Eigen::MatrixXd::Zero(parameters, parameters)),
        score(Eigen::VectorXd::Zero(parameters)) {}
};

struct Precision {
  Eigen::VectorXd half_width;  // NaN where the data tell nothing, and of fixed parameters
  // Of the errors of the estimates, from B: whether the data can tell parameters apart. 0 where
  // there is none.
  Eigen::MatrixXd correlation;
};

// `fixed` parameters (those at a bound) are taken as known. At least two episodes.
Precision precision(const std::vector<EpisodeSums>& episodes, const std::vector<bool>& fixed);

// Weight of Huber's loss with threshold `huber` at a residual of size `size`.
inline double huber_weight(double size, double huber) noexcept {
  return size > huber ? huber / size : 1;
}

}  // namespace ferrule
