#include "controller/search/touch_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/controller/search/face_oracle.hpp"
#include "tests/controller/search/in_c.hpp"

namespace ferrule {
namespace {

using Eigen::Vector2d;
using testing::in_c, testing::in_eigen;

constexpr double um = 1e-6;
constexpr ferrule_touch_numbers kNumbers = {62.5 * um, 63 * um, 150 * um, 150.7 * um,
                                            8 * um,    6e-3,    1 * um};

struct TouchPlace {
  Vector2d across = Vector2d::Zero(), tilt = Vector2d::Zero();
};

class TouchSearch {
 public:
  TouchSearch() { ferrule_touches_start(&touches_, kNumbers); }
  TouchPlace next() const { return {in_eigen(touches_.next_across), in_eigen(touches_.next_tilt)}; }
  void rested(double x, const TouchPlace& at, double height) {
    ferrule_rested(&touches_, {x, in_c(at.across), in_c(at.tilt)}, height);
  }
  double highest_rest() const { return ferrule_highest_rest(&touches_); }
  double lowest_rest() const { return ferrule_lowest_rest(&touches_); }

 private:
  ferrule_touches touches_;
};

// A flat end of `slope`, at first `e` off the axis of an opening of radius `opening` in a face
// `height` before the bore's entrance.
struct Face {
  Vector2d e, slope;
  double opening, height;

  double off(const TouchPlace& place) const { return (e + place.across).norm(); }
  bool goes_in(const TouchPlace& place) const { return off(place) < opening - 62.5 * um; }
  double rests_at(const TouchPlace& place) const {
    return height + testing::rest_height_by_trial({62.5 * um, opening}, slope + place.tilt,
                                                  e + place.across);
  }
};

// Touches until the end goes in; 0: it does not. `error` of the heights [m].
int touches_until_in(const Face& face, std::mt19937& random, double error = 1e-9) {
  std::normal_distribution<double> noise(0, error);
  TouchSearch search;
  for (int touches = 1; touches < 100; ++touches) {
    const TouchPlace place = search.next();
    const double x = face.rests_at(place) + noise(random);
    search.rested(x, place, x);
    if (face.goes_in(search.next())) return touches;
  }
  return 0;
}

TEST(TouchSearch, FindsASharpBoreFromMicrometresAndFromFarOff) {
  std::mt19937 random(1);
  int most = 0;
  for (int k = 0; k < 30; ++k) {
    const double scatter = (k % 3 == 0 ? 2 : k % 3 == 1 ? 15 : 30) * um;
    const Face face = {scatter * testing::drawn(random), 1e-3 * testing::drawn(random), 63 * um, 0};
    if (face.goes_in({})) continue;
    const int touches = touches_until_in(face, random);
    EXPECT_GT(touches, 0) << face.e.transpose() / um;
    most = std::max(most, touches);
  }
  EXPECT_LE(most, 40);
}

TEST(TouchSearch, FindsItWithACleavedEndWhoseSlopeNobodyTold) {
  std::mt19937 random(2);
  for (int k = 0; k < 12; ++k) {
    const double direction = k;
    const Face face = {15 * um * testing::drawn(random),
                       17e-3 * Vector2d(std::cos(direction), std::sin(direction)), 63 * um, 0};
    EXPECT_GT(touches_until_in(face, random), 0) << face.e.transpose() / um;
  }
}

TEST(TouchSearch, FindsTheMouthOfALeadInFromTheFace) {
  std::mt19937 random(3);
  for (int k = 0; k < 10; ++k) {
    const Face face = {Vector2d(110 * um, 0) + 15 * um * testing::drawn(random),
                       1e-3 * testing::drawn(random), 150 * um, 150.7 * um};
    EXPECT_GT(touches_until_in(face, random), 0) << face.e.transpose() / um;
  }
}

// On the cone the rim's point on the far side is caught, wherever the end is tilted to.
TEST(TouchSearch, GoesFromAConeToTheAxisInOneStep) {
  const Vector2d e(-9 * um, 14 * um), side = e.normalized();
  const double widening = (150 - 63) / 150.7;
  TouchSearch search;
  for (int touches = 0; touches < 4; ++touches) {
    const TouchPlace place = search.next();
    EXPECT_EQ(place.across.norm(), 0);
    const double upright = (e.norm() - 0.5 * um) / widening;
    const double x = upright + 62.5 * um * place.tilt.dot(side);
    search.rested(x, place, x);
  }
  EXPECT_LT((search.next().across + e).norm(), 0.01 * um);
  EXPECT_EQ(search.next().tilt.norm(), 0);
}

TEST(TouchSearch, SaysBetweenWhichHeightsTheEndCanRestOnTheFace) {
  const Face face = {Vector2d(12 * um, 5 * um), Vector2d(1e-3, -2e-3), 63 * um, 0};
  std::mt19937 random(4);
  TouchSearch search;
  for (int touches = 0; touches < 12; ++touches) {
    const TouchPlace place = search.next();
    if (face.goes_in(place)) break;
    const double x = face.rests_at(place);
    if (touches > 9) {
      EXPECT_LE(x, search.highest_rest() + 5e-9);
      EXPECT_GE(x, search.lowest_rest() - 5e-9);
    }
    search.rested(x, place, x);
  }
}

}  // namespace
}  // namespace ferrule
