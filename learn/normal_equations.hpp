// Linear least squares by the normal equations.
#pragma once

#include <Eigen/Core>

namespace ferrule {

// The x that minimises |A x - b|^2, the shortest where several do: of A^T A (n, n) and A^T b (n).
// In a file of its own, since Eigen's complete orthogonal decomposition compiles for ten seconds.
Eigen::VectorXd least_squares(const Eigen::MatrixXd& ata, const Eigen::VectorXd& atb);

}  // namespace ferrule
