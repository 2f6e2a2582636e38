#include "haptic/passivity.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/compare.hpp"
#include "tests/haptic/sample_period.hpp"

namespace ferrule {
namespace {

using Eigen::Vector3d;

TEST(PassivityController, EnergyIsTheWorkOfTheHand) {
  PassivityController passivity(T, 0);
  double work = 0;
  Vector3d before = Vector3d::Zero(), held = Vector3d::Zero();
  for (int n = 0; n < 1000; ++n) {
    const Vector3d hand = 1e-3 * Vector3d(std::sin(0.01 * n), std::cos(0.02 * n), 1e-3 * n);
    if (n > 0) work -= held.dot(hand - before);
    const Vector3d force(-300 * hand.x(), 1.0, std::sin(0.3 * n));
    held = passivity.pass(hand, force);
    EXPECT_EQ(held, force) << "without damping it passes on";
    before = hand;
  }
  EXPECT_CLOSE(passivity.energy(), work, 1e-12);
}

TEST(PassivityController, LeavesSpringsMetAtPaceAndDampersAlone) {
  PassivityController passivity(T, 100);
  Vector3d before = Vector3d::Zero();
  for (int n = 0; n < 2000; ++n) {
    const Vector3d hand(1e-2 * std::sin(0.01 * n), 0, 0);
    const Vector3d force = -200 * hand - 5 * (hand - before) / T;
    EXPECT_EQ(passivity.pass(hand, force), force);
    EXPECT_GE(passivity.energy(), 0);
    before = hand;
  }
}

TEST(PassivityController, TakesBackWhatWasGivenOutInTheNextPeriod) {
  PassivityController passivity(T, 1e6);
  const Vector3d step(1e-4, -2e-4, 0);
  passivity.pass(Vector3d::Zero(), 2 * Vector3d(1, -2, 0));  // pushes along: gives energy out
  const Vector3d out = passivity.pass(step, Vector3d::Zero());
  const double given = 2e-4 + 8e-4;
  EXPECT_CLOSE(passivity.energy(), -given, 1e-12);
  EXPECT_CLOSE(passivity.damping(), given * T / step.squaredNorm(), 1e-12);
  EXPECT_CLOSE(out.dot(step), -given, 1e-12);
  passivity.pass(2 * step, Vector3d::Zero());  // the hand goes on as it did
  EXPECT_LT(std::abs(passivity.energy()), 1e-12 * given);
}

TEST(PassivityController, DampsNoMoreThanItsLimitAndKeepsTheRestInMind) {
  PassivityController passivity(T, 3);
  const Vector3d step(1e-4, 0, 0);
  passivity.pass(Vector3d::Zero(), {2, 0, 0});
  Vector3d out = passivity.pass(step, Vector3d::Zero());
  EXPECT_EQ(passivity.damping(), 3);
  EXPECT_CLOSE(out.x(), -3 * 0.1, 1e-12);
  passivity.pass(2 * step, Vector3d::Zero());
  EXPECT_CLOSE(passivity.energy(), -2e-4 + 3e-5, 1e-12);
  EXPECT_EQ(passivity.pass(2 * step, {1, 0, 0}), Vector3d(1, 0, 0))
      << "a resting hand is not pushed";
}

}  // namespace
}  // namespace ferrule
