#include "capture/felt_difference.hpp"

#include "insertion/scene_scaling.hpp"
#include "tests/compare.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

constexpr int kPlaces = 20;

// Ten rows at each micrometre on the way in; from the sixth micrometre on something touches, and
// the hand feels that force [N, in its world].
Episode pushing(const Scene& scene, double felt) {
  const double to_tip = 1 / scene_scaling(scene).force;
  Episode episode;
  episode.rows = Rows::Zero(10 * kPlaces, kRowSize);
  for (int n = 0; n < 10 * kPlaces; ++n) {
    const int place = n / 10;
    episode.rows(n, kTime.begin) = 1e-3 * n;
    episode.rows(n, state_column("hand_x")) = 1e-6 * (5 - place);
    episode.rows(n, kHolder.begin + 1) = -3e-6;  // a weight, which is there at rest
    if (place < 5) continue;
    episode.rows(n, state_column("end_closed")) = 1;
    episode.rows(n, kHolder.begin) = to_tip * felt;
  }
  return episode;
}

TEST(FeltDifference, IsNoticedFromATenthOn) {
  const Scene scene = testing::paper();
  for (const auto& [a, b, noticed] :
       {std::tuple(3.0, 3.0, false), {3.0, 3.29, false}, {3.0, 3.4, true}, {3.4, 3.0, true}}) {
    const FeltDifference d = felt_difference(pushing(scene, a), scene, pushing(scene, b), scene);
    EXPECT_EQ(d.all.stretches, kPlaces);
    EXPECT_EQ(d.either_touches.stretches, kPlaces - 5);
    EXPECT_EQ(d.either_touches.noticed, noticed) << a << " " << b;
    EXPECT_CLOSE(d.all.noticed, noticed ? (kPlaces - 5.0) / kPlaces : 0.0, 1e-12);
    EXPECT_CLOSE(d.either_touches.median, std::abs(a - b), 1e-9);
    EXPECT_CLOSE(d.either_touches.largest, std::abs(a - b), 1e-9);
  }
}

TEST(FeltDifference, BelowATenthOfANewtonIsNotNoticed) {
  const Scene scene = testing::paper();
  EXPECT_EQ(felt_difference(pushing(scene, 0), scene, pushing(scene, 0.099), scene).all.noticed, 0);
  EXPECT_GT(felt_difference(pushing(scene, 0), scene, pushing(scene, 0.101), scene).all.noticed, 0);
}

TEST(FeltDifference, ComparesWhereBothHaveBeen) {
  const Scene scene = testing::paper();
  Episode shorter = pushing(scene, 1);
  shorter.rows.conservativeResize(10 * 8, Eigen::NoChange);
  EXPECT_EQ(felt_difference(shorter, scene, pushing(scene, 2), scene).all.stretches, 8);
  shorter.rows.col(state_column("hand_x")).array() += 1;
  const FeltDifference apart = felt_difference(shorter, scene, pushing(scene, 2), scene);
  EXPECT_EQ(apart.all.stretches, 0);
  EXPECT_TRUE(std::isnan(apart.all.noticed));
}

// One begins to touch three micrometres before the other.
TEST(FeltDifference, TellsWhereBothTouchFromWhereOneDoes) {
  const Scene scene = testing::paper();
  const Episode touches = pushing(scene, 1);
  Episode later = pushing(scene, 2);
  for (int n = 50; n < 80; ++n) later.rows(n, state_column("end_closed")) = 0;
  const FeltDifference d = felt_difference(touches, scene, later, scene);
  EXPECT_EQ(d.either_touches.stretches, kPlaces - 5);
  EXPECT_EQ(d.both_touch.stretches, kPlaces - 8);
  EXPECT_EQ(d.both_touch.noticed, 1);
  EXPECT_CLOSE(d.both_touch.median, 1, 1e-9);
}

}  // namespace
}  // namespace ferrule
