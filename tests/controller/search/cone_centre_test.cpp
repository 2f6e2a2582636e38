#include "controller/search/cone_centre.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/controller/search/in_c.hpp"

namespace ferrule {
namespace {

using Eigen::Vector2d;
using testing::in_c, testing::in_eigen;

ferrule_cone roughly(double play) {
  ferrule_cone cone;
  ferrule_cone_start(&cone, false, play);
  return cone;
}
ferrule_cone finely() {
  ferrule_cone cone;
  ferrule_cone_start(&cone, true, 0);
  return cone;
}

Vector2d centre_of_circle(const Vector2d& first, const Vector2d& second, double radius) {
  return in_eigen(ferrule_centre_of_circle(in_c(first), in_c(second), radius));
}

// Where an end at `from` that moves in that direction meets the circle of radius `play` about
// `axis`: the root of |from + s to - axis| = play, s > 0.
Vector2d touches_at(const Vector2d& from, const Vector2d& to, const Vector2d& axis, double play) {
  const Vector2d e = from - axis;
  const double b = e.dot(to);
  return from + (-b + std::sqrt(b * b - e.squaredNorm() + play * play)) * to;
}

// Goes where `centre` says from `start`, in a cone with that play, until it has ended.
Vector2d followed(ferrule_cone& centre, const Vector2d& start, const Vector2d& axis, double play) {
  Vector2d at = start;
  for (int moves = 0; moves < 10 && !ferrule_cone_ended(&centre); ++moves) {
    const Vector2d to = in_eigen(centre.to);
    at = centre.until_felt ? touches_at(at, to, axis, play) : to;
    ferrule_cone_arrived(&centre, in_c(at));
  }
  EXPECT_TRUE(ferrule_cone_ended(&centre));
  return at;
}

const Vector2d kConeAxes[] = {
    {0, 0}, {13e-6, 5e-6}, {-21e-6, 17e-6}, {-8e-6, -30e-6}, {2e-6, 36e-6}};

TEST(ConeCentre, TwoPlacesOnACircleOfKnownRadiusHaveItsCentre) {
  const Vector2d centre(3e-6, -7e-6);
  const double radius = 44e-6;
  for (const double first : {-1.2, -0.4, 0.0, 0.9})
    for (const double further : {0.1, 1.0, 1.6, 3.1}) {
      const double second = first + further;
      const Vector2d a = centre + radius * Vector2d(std::cos(first), std::sin(first));
      const Vector2d b = centre + radius * Vector2d(std::cos(second), std::sin(second));
      EXPECT_LT((centre_of_circle(a, b, radius) - centre).norm(), 1e-9 * radius)
          << first << " " << second;
    }
}

TEST(ConeCentre, PlacesThatNoSuchCircleGoesThroughHaveTheirMiddle) {
  const Vector2d a(1, 0), b(0, 1);
  EXPECT_EQ(centre_of_circle(a, b, 0.5), Vector2d(0.5, 0.5));
  EXPECT_EQ(centre_of_circle(a, a, 0.5), a);
}

TEST(ConeCentre, RoughlyWithTheRightPlayItIsOnTheAxisWhereverItBegan) {
  const double play = 44e-6;
  for (const Vector2d& axis : kConeAxes) {
    ferrule_cone centre = roughly(play);
    const Vector2d at = followed(centre, Vector2d::Zero(), axis, play);
    EXPECT_LT((at - axis).norm(), 1e-9 * play) << axis.transpose();
  }
}

// A cone that is 5 um higher than believed has 2.9 um more play.
TEST(ConeCentre, RoughlyWithAWrongPlayItIsOffByNoMuchMoreThanThat) {
  for (const Vector2d& axis : kConeAxes) {
    ferrule_cone centre = roughly(41e-6);
    const Vector2d at = followed(centre, Vector2d::Zero(), axis, 44e-6);
    EXPECT_LT((at - axis).norm(), 2.5 * 3e-6) << axis.transpose();
    EXPECT_GT((at - axis).norm(), 0.5e-6);
  }
}

// Off the axis by e, both ways along y tell y, and the play but for e^2/2p; z is off by e^2/p.
TEST(ConeCentre, FinelyItFindsTheAxisAndThePlay) {
  const double play = 18e-6;
  for (const Vector2d& axis : {Vector2d(0.5e-6, 1e-6), Vector2d(-2e-6, 1.5e-6)}) {
    ferrule_cone centre = finely();
    const Vector2d at = followed(centre, Vector2d::Zero(), axis, play);
    const double error = axis.squaredNorm() / play;
    EXPECT_NEAR(at.x(), axis.x(), 1e-9 * play);
    EXPECT_NEAR(at.y(), axis.y(), error);
    EXPECT_NEAR(centre.play, play, error);
  }
}

TEST(ConeCentre, SaysWhereItTouchedLast) {
  ferrule_cone centre = roughly(1);
  ferrule_cone_arrived(&centre, {0.9, 0});
  EXPECT_EQ(in_eigen(centre.touched), Vector2d(0.9, 0));
  ferrule_cone_arrived(&centre, {-0.1, 0});
  EXPECT_EQ(in_eigen(centre.touched), Vector2d(0.9, 0));
  ferrule_cone_arrived(&centre, {-0.1, 0.8});
  EXPECT_EQ(in_eigen(centre.touched), Vector2d(-0.1, 0.8));
}

}  // namespace
}  // namespace ferrule
