#include "learn/normal_equations.hpp"

#include <Eigen/QR>

namespace ferrule {

Eigen::VectorXd least_squares(const Eigen::MatrixXd& ata, const Eigen::VectorXd& atb) {
  return ata.completeOrthogonalDecomposition().solve(atb);
}

}  // namespace ferrule
