#include "sim/solver/follow.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "tests/scenes.hpp"

namespace ferrule {
namespace {

TEST(Follow, ShowsTheForcesWhereItStartsAndThenAStepPerPose) {
  const Scene scene = testing::paper();
  const State start = at_rest(scene.world, testing::pose(2e-6, 0.2e-6, 0));
  const auto hand = [&](std::ptrdiff_t n) {
    Pose pose = start.command;
    pose[0] -= 50e-9 * static_cast<double>(n);
    return pose;
  };
  std::vector<StepResult> shown;
  follow(scene.world, start, 100, 1e-3, hand, [&](std::ptrdiff_t n, const StepResult& result) {
    EXPECT_EQ(n, std::ssize(shown));
    shown.push_back(result);
    return n < 79;
  });
  ASSERT_EQ(shown.size(), 80u) << "until it is told to end";
  EXPECT_EQ(shown[0].state.time, 0);
  StepResult expected(start);
  for (std::size_t n = 0; n < shown.size(); ++n) {
    step_on(scene.world, hand(static_cast<std::ptrdiff_t>(n)), n == 0 ? 0.0 : 1e-3, expected);
    EXPECT_EQ(to_row(shown[n].state), to_row(expected.state));
    EXPECT_EQ(shown[n].holder, expected.holder);
  }
}

}  // namespace
}  // namespace ferrule
