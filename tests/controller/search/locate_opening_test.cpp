#include "controller/search/locate_opening.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "tests/controller/search/face_oracle.hpp"
#include "tests/controller/search/in_c.hpp"

namespace ferrule {
namespace {

using Eigen::Vector2d;
using testing::in_c, testing::in_eigen;

constexpr ferrule_discs kDiscs = {62.5e-6, 63e-6};
constexpr ferrule_touch_errors kErrors = {6e-9, 62.5e-6, 0.02, 0.7};

double rest_height(const ferrule_discs& discs, const Vector2d& slope, const Vector2d& e) {
  return ferrule_rests(discs, in_c(slope), in_c(e)).ahead;
}

ferrule_opening located(const std::vector<ferrule_axes>& touches,
                        const ferrule_touch_errors& errors = kErrors,
                        const ferrule_discs& discs = kDiscs) {
  return ferrule_locate_opening(touches.data(), static_cast<int>(touches.size()), discs, errors);
}

TEST(RestHeight, IsThatOfEveryPointOfTheCrescentTried) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int k = 0; k < 300; ++k) {
    const double far = 110e-6 * std::abs(uniform(random)) + 0.6e-6;
    const double angle = std::numbers::pi * uniform(random);
    const Vector2d e = far * Vector2d(std::cos(angle), std::sin(angle));
    const Vector2d slope = 5e-3 * Vector2d(uniform(random), uniform(random));
    const double tried = testing::rest_height_by_trial(kDiscs, slope, e);
    // The points are 1.6e-4 rad apart.
    EXPECT_NEAR(rest_height(kDiscs, slope, e), tried, 1.6e-4 * slope.norm() * kDiscs.fibre)
        << e.transpose() << " " << slope.transpose();
  }
}

TEST(RestHeight, HasTheDerivativesThatDifferencesGive) {
  std::mt19937 random(6);
  for (int k = 0; k < 300; ++k) {
    const Vector2d e = 40e-6 * testing::drawn(random), slope = 5e-3 * testing::drawn(random);
    if (e.norm() < 0.6e-6) continue;
    const ferrule_rest rest = ferrule_rests(kDiscs, in_c(slope), in_c(e));
    for (int i = 0; i < 2; ++i) {
      const Vector2d by_e = 1e-11 * Vector2d::Unit(i), by_slope = 1e-9 * Vector2d::Unit(i);
      const double differs_e =
          (rest_height(kDiscs, slope, e + by_e) - rest_height(kDiscs, slope, e - by_e)) / 2e-11;
      const double differs_slope =
          (rest_height(kDiscs, slope + by_slope, e) - rest_height(kDiscs, slope - by_slope, e)) /
          2e-9;
      EXPECT_NEAR(in_eigen(rest.by_e)[i], differs_e, 1e-4 * slope.norm()) << e.transpose();
      EXPECT_NEAR(in_eigen(rest.point)[i], differs_slope, 1e-6 * kDiscs.fibre) << e.transpose();
    }
  }
}

TEST(RestHeight, OfADiscAtTheOpeningsEdgeIsThatOfThePointThatTouches) {
  const Vector2d slope(2e-3, -1e-3), side(0.6, 0.8);
  for (const double off : {0.0, 0.2e-6, 0.5e-6})
    EXPECT_NEAR(rest_height(kDiscs, slope, off > 0 ? Vector2d(off * side) : Vector2d(1e-12 * side)),
                kDiscs.fibre * slope.dot(side), 2e-3 * kDiscs.fibre * slope.norm())
        << off;
}

std::vector<ferrule_axes> ring(const Vector2d& axis, const Vector2d& slope, double face,
                               double error, std::mt19937& random) {
  std::normal_distribution<double> normal(0, error);
  std::vector<ferrule_axes> touches;
  for (int k = -1; k < 8; ++k) {
    const double angle = std::numbers::pi / 4 * k;
    const Vector2d tilt =
        k < 0 ? Vector2d(0, 0) : Vector2d(6e-3 * Vector2d(std::cos(angle), std::sin(angle)));
    const double h = testing::rest_height_by_trial(kDiscs, slope + tilt, -axis);
    touches.push_back({face + h + normal(random), {0, 0}, in_c(tilt)});
  }
  return touches;
}

TEST(LocateOpening, FindsItFromNineTouches) {
  std::mt19937 random(2);
  for (int k = 0; k < 40; ++k) {
    const Vector2d axis = 15e-6 * testing::drawn(random), slope = 1e-3 * testing::drawn(random);
    const ferrule_opening found = located(ring(axis, slope, 3e-6, 1e-9, random));
    EXPECT_LT((in_eigen(found.axis) - axis).norm(), 0.3e-6 + 0.15 * axis.norm())
        << axis.transpose() << " " << slope.transpose();
    EXPECT_NEAR(found.face, 3e-6, 10e-9);
    EXPECT_LT(found.misfit, 3e-9);
  }
}

// Touches from one place fit a wider opening further away nearly as well, by a nanometre; those
// from two places, and heights good to 0.1 nm, tell which.
TEST(LocateOpening, FindsTheClearanceToo) {
  std::mt19937 random(5);
  for (const double clearance : {0.1e-6, 0.25e-6, 0.5e-6, 0.75e-6}) {
    const ferrule_discs parts = {kDiscs.fibre, kDiscs.fibre + clearance};
    const Vector2d axis = 12e-6 * testing::drawn(random), slope = 1e-3 * testing::drawn(random);
    std::vector<ferrule_axes> touches;
    for (const Vector2d& across : {Vector2d(0, 0), Vector2d(0.9 * axis)})
      for (int k = 0; k < 8; ++k) {
        const double angle = std::numbers::pi / 4 * k;
        const Vector2d tilt = 6e-3 * Vector2d(std::cos(angle), std::sin(angle));
        const double h = rest_height(parts, slope + tilt, across - axis);
        touches.push_back({h, in_c(across), in_c(tilt)});
      }
    const ferrule_opening found = located(touches, {1e-10, 62.5e-6, 0.02, 0.7});
    EXPECT_NEAR(found.clearance, clearance, 0.1 * clearance);
    EXPECT_LT((in_eigen(found.axis) - axis).norm(), 0.02 * axis.norm()) << clearance;
    const ferrule_touch_errors certain = {6e-9, 62.5e-6, 0.02, 1e-6};
    EXPECT_NEAR(located(touches, certain).clearance, 0.5e-6, 1e-11);
  }
}

TEST(LocateOpening, IsTheSameInTheHandsWorldAndTheTips) {
  constexpr double kMagnified = 250;
  std::mt19937 random(3);
  std::vector<ferrule_axes> touches = ring({8e-6, -11e-6}, {1e-3, 0.5e-3}, 0, 1e-9, random);
  const ferrule_opening tip = located(touches);
  for (ferrule_axes& touch : touches)
    touch.x *= kMagnified, touch.across = ferrule_times(kMagnified, touch.across);
  const ferrule_opening hand =
      located(touches, {kMagnified * 6e-9, kMagnified * 62.5e-6, 0.02, 0.7},
              {kMagnified * kDiscs.fibre, kMagnified * kDiscs.opening});
  EXPECT_LT((in_eigen(hand.axis) / kMagnified - in_eigen(tip.axis)).norm(),
            1e-4 * in_eigen(tip.axis).norm());
  EXPECT_LT((in_eigen(hand.slope) - in_eigen(tip.slope)).norm(), 1e-4 * in_eigen(tip.slope).norm());
}

TEST(LocateOpening, SaysHowFarTheTouchesAreFromWhatAnyOpeningWouldGive) {
  std::mt19937 random(4);
  std::vector<ferrule_axes> touches = ring({8e-6, -11e-6}, {1e-3, 0.5e-3}, 0, 0, random);
  touches[3].x += 300e-9;  // it slid
  EXPECT_GT(located(touches).misfit, 30e-9);
}

}  // namespace
}  // namespace ferrule
