#include "controller/locate_opening.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "tests/controller/face_oracle.hpp"

namespace ferrule {
namespace {

using Eigen::Vector2d;

constexpr Discs kDiscs = {62.5e-6, 63e-6};

TEST(RestHeight, IsThatOfEveryPointOfTheCrescentTried) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int k = 0; k < 300; ++k) {
    const double far = 110e-6 * std::abs(uniform(random)) + 0.6e-6;
    const double angle = std::numbers::pi * uniform(random);
    const Vector2d e = far * Vector2d(std::cos(angle), std::sin(angle));
    const Vector2d slope = 5e-3 * Vector2d(uniform(random), uniform(random));
    const double tried = testing::rest_height_by_trial(kDiscs, slope, e);
    // The transition of a real contact, within 1e-5 of tilt, and the spacing of the points.
    EXPECT_NEAR(rest_height(kDiscs, slope, e), tried, 1e-5 * kDiscs.fibre + 1e-4 * std::abs(tried))
        << e.transpose() << " " << slope.transpose();
  }
}

TEST(RestHeight, OfADiscAtTheOpeningsEdgeIsThatOfThePointThatTouches) {
  const Vector2d slope(2e-3, -1e-3), side(0.6, 0.8);
  for (const double off : {0.0, 0.2e-6, 0.5e-6})
    EXPECT_NEAR(rest_height(kDiscs, slope, off > 0 ? Vector2d(off * side) : Vector2d(1e-12 * side)),
                kDiscs.fibre * slope.dot(side), 2e-3 * kDiscs.fibre * slope.norm())
        << off;
}

std::vector<Touch> ring(const Vector2d& axis, const Vector2d& slope, double face, double error,
                        std::mt19937& random) {
  std::normal_distribution<double> normal(0, error);
  std::vector<Touch> touches;
  for (int k = -1; k < 8; ++k) {
    const double angle = std::numbers::pi / 4 * k;
    const Vector2d tilt =
        k < 0 ? Vector2d(0, 0) : Vector2d(6e-3 * Vector2d(std::cos(angle), std::sin(angle)));
    const double h = testing::rest_height_by_trial(kDiscs, slope + tilt, -axis);
    touches.push_back({face + h + normal(random), Vector2d::Zero(), tilt});
  }
  return touches;
}

TEST(LocateOpening, FindsItFromNineTouches) {
  std::mt19937 random(2);
  for (int k = 0; k < 40; ++k) {
    const Vector2d axis = 15e-6 * testing::drawn(random), slope = 1e-3 * testing::drawn(random);
    const Opening found = locate_opening(ring(axis, slope, 3e-6, 1e-9, random), kDiscs,
                                         {.height = 6e-9, .far = 62.5e-6});
    EXPECT_LT((found.axis - axis).norm(), 0.3e-6 + 0.15 * axis.norm())
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
    const Discs parts = {kDiscs.fibre, kDiscs.fibre + clearance};
    const Vector2d axis = 12e-6 * testing::drawn(random), slope = 1e-3 * testing::drawn(random);
    std::vector<Touch> touches;
    for (const Vector2d& across : {Vector2d(0, 0), Vector2d(0.9 * axis)})
      for (int k = 0; k < 8; ++k) {
        const double angle = std::numbers::pi / 4 * k;
        const Vector2d tilt = 6e-3 * Vector2d(std::cos(angle), std::sin(angle));
        const double h = rest_height(parts, slope + tilt, across - axis);
        touches.push_back({h, across, tilt});
      }
    const Opening found = locate_opening(touches, kDiscs, {.height = 1e-10, .far = 62.5e-6});
    EXPECT_NEAR(found.clearance, clearance, 0.1 * clearance);
    EXPECT_LT((found.axis - axis).norm(), 0.02 * axis.norm()) << clearance;
    const TouchErrors certain = {.height = 6e-9, .far = 62.5e-6, .clearance = 1e-6};
    EXPECT_NEAR(locate_opening(touches, kDiscs, certain).clearance, 0.5e-6, 1e-11);
  }
}

TEST(LocateOpening, IsTheSameInTheHandsWorldAndTheTips) {
  constexpr double kMagnified = 250;
  std::mt19937 random(3);
  std::vector<Touch> touches = ring({8e-6, -11e-6}, {1e-3, 0.5e-3}, 0, 1e-9, random);
  const Opening tip = locate_opening(touches, kDiscs, {.height = 6e-9, .far = 62.5e-6});
  for (Touch& touch : touches) touch.x *= kMagnified, touch.across *= kMagnified;
  const Opening hand =
      locate_opening(touches, {kMagnified * kDiscs.fibre, kMagnified * kDiscs.opening},
                     {.height = kMagnified * 6e-9, .far = kMagnified * 62.5e-6});
  EXPECT_LT((hand.axis / kMagnified - tip.axis).norm(), 1e-4 * tip.axis.norm());
  EXPECT_LT((hand.slope - tip.slope).norm(), 1e-4 * tip.slope.norm());
}

TEST(LocateOpening, SaysHowFarTheTouchesAreFromWhatAnyOpeningWouldGive) {
  std::mt19937 random(4);
  std::vector<Touch> touches = ring({8e-6, -11e-6}, {1e-3, 0.5e-3}, 0, 0, random);
  touches[3].x += 300e-9;  // it slid
  EXPECT_GT(locate_opening(touches, kDiscs, {.height = 6e-9, .far = 62.5e-6}).misfit, 30e-9);
}

}  // namespace
}  // namespace ferrule
