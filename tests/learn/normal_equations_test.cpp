#include "learn/normal_equations.hpp"

#include <gtest/gtest.h>

namespace ferrule {
namespace {

// Of the line through (0, 1), (1, 3), (2, 5), (3, 6): slope 1.7, intercept 1.2.
TEST(LeastSquares, FitsALine) {
  Eigen::MatrixXd a(4, 2);
  a << 0, 1, 1, 1, 2, 1, 3, 1;
  const Eigen::Vector4d b(1, 3, 5, 6);
  const Eigen::VectorXd x = least_squares(a.transpose() * a, a.transpose() * b);
  EXPECT_NEAR(x[0], 1.7, 1e-13);
  EXPECT_NEAR(x[1], 1.2, 1e-13);
}

// x + 2 y = 5 alone: the point nearest to the origin is (1, 2).
TEST(LeastSquares, TakesTheShortestOfMany) {
  const Eigen::RowVector2d a(1, 2);
  const Eigen::VectorXd x = least_squares(a.transpose() * a, a.transpose() * 5);
  EXPECT_NEAR(x[0], 1, 1e-13);
  EXPECT_NEAR(x[1], 2, 1e-13);
}

TEST(LeastSquares, OfNothingIsNothing) {
  const Eigen::VectorXd x = least_squares(Eigen::Matrix3d::Zero(), Eigen::Vector3d::Zero());
  EXPECT_EQ(x, Eigen::Vector3d::Zero());
}

}  // namespace
}  // namespace ferrule
