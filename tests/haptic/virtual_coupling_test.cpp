#include "haptic/virtual_coupling.hpp"

#include "sim/base/random.hpp"
#include "tests/compare.hpp"
#include "tests/haptic/sample_period.hpp"

namespace ferrule {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

TEST(VirtualCoupling, HolderGoesWithTheHandInFreeAir) {
  VirtualCoupling coupling({1000, 0.5}, T, Vector3d::Zero());
  for (int n = 1; n < 100; ++n) {
    const Vector3d hand(1e-4 * n, -2e-5 * n * n, 3e-3 * std::sin(0.1 * n));
    EXPECT_LT((coupling.move(hand, Vector3d::Zero(), Matrix3d::Zero()) - hand).norm(), 1e-15);
    EXPECT_LT(coupling.force().norm(), 1e-9);
  }
}

TEST(VirtualCoupling, FeelsInSeriesWithAnySpring) {
  RandomStream random(3, 0, Draw::start);
  for (int trial = 0; trial < 200; ++trial) {
    // A symmetric spring with modes over nine decades.
    const Matrix3d any = Matrix3d::NullaryExpr([&] { return random.uniform() - 0.5; });
    const Eigen::SelfAdjointEigenSolver<Matrix3d> frame(any + any.transpose());
    const Vector3d modes =
        Vector3d::NullaryExpr([&] { return std::pow(10, 9 * random.uniform() - 1); });
    const Matrix3d K = frame.eigenvectors() * modes.asDiagonal() * frame.eigenvectors().transpose();
    const double K_c = 10 + 3000 * random.uniform();
    VirtualCoupling coupling({K_c, 2 * random.uniform()}, T, Vector3d::Zero());
    const Vector3d hand = 0.01 * Vector3d::NullaryExpr([&] { return random.uniform() - 0.5; });
    Vector3d holder = Vector3d::Zero();
    for (int n = 0; n < 3000; ++n) holder = coupling.move(hand, -K * holder, K);
    const Vector3d along = frame.eigenvectors().transpose() * hand;
    const Vector3d series = (modes.array() * K_c / (modes.array() + K_c)).matrix();
    const Vector3d force = -frame.eigenvectors() * series.cwiseProduct(along);
    EXPECT_LT((coupling.force() - force).norm(), 1e-6 * force.norm());
  }
}

TEST(VirtualCoupling, AgainstARigidWallIsItsSpringAndDamper) {
  const Coupling c{800, 0.7};
  VirtualCoupling coupling(c, T, Vector3d::Zero());
  Vector3d before = Vector3d::Zero();
  for (int n = 1; n < 50; ++n) {
    const Vector3d hand = 1e-3 * Vector3d(std::sin(0.2 * n), std::cos(0.3 * n) - 1, 1e-2 * n);
    coupling.move(hand, Vector3d::Zero(), 1e12 * Matrix3d::Identity());
    const Vector3d force = -c.stiffness * hand - c.damping / T * (hand - before);
    EXPECT_LT((coupling.force() - force).norm(), 1e-6 * force.norm());
    before = hand;
  }
}

TEST(VirtualCoupling, SettlesWhereTheStiffnessWasOverestimated) {
  for (const double estimate : {1.0, 3.0, 100.0}) {
    VirtualCoupling coupling({1000, 0}, T, Vector3d::Zero());
    const double K = 5000;
    const Vector3d hand(1e-3, 0, 0);
    Vector3d holder = Vector3d::Zero();
    double before = 0;
    for (int n = 0; n < 20000; ++n) {
      holder = coupling.move(hand, -K * holder, estimate * K * Matrix3d::Identity());
      EXPECT_GE(holder.x(), before - 1e-18) << "without overshoot";
      before = holder.x();
    }
    EXPECT_CLOSE(holder.x(), 1e-3 / 6, 1e-6);
  }
}

}  // namespace
}  // namespace ferrule
