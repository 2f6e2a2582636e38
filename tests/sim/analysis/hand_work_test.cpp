#include "sim/analysis/hand_work.hpp"

#include <gtest/gtest.h>

#include "sim/solver/step.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

// Against the wall of a bore and on along it in so many steps: nothing rubs, so that what the hand
// loses is what an implicit step damps, and half as much at half the step.
double lost_share(const World& world, int steps) {
  const State start = at_rest(world, testing::pose(5e-6, 0, 0));
  const Pose way = testing::pose(-35e-6, 2e-6, -1e-6, 2e-3, 0);
  StepResult now(start);
  State& state = now.state;
  HandWork work(world, start);
  for (int n = 1; n <= steps; ++n) {
    const Pose hand = start.command + static_cast<double>(n) / steps * way;
    work.move(state, hand);
    step_on(world, hand, 1e-3, now);
  }
  EXPECT_FALSE(work.gained(state));
  const double stored = stored_energy(world, state) - stored_energy(world, start);
  EXPECT_GT(stored, 0.1 * work.turned());
  return (work.work() - stored) / stored;
}

TEST(HandWork, IsStoredWhereNothingDissipates) {
  const World world = testing::bare({"laws.gravity={\"form\":\"corrected\"}"}).world;
  const double coarse = lost_share(world, 2000), fine = lost_share(world, 4000);
  EXPECT_LT(coarse, 2e-2);
  EXPECT_NEAR(coarse / fine, 2, 0.1);
}

TEST(HandWork, TellsAnEndThatHasMoreThanTheHandGave) {
  const World world = testing::bare().world;
  const State start = at_rest(world, testing::pose(5e-6, 0, 0));
  HandWork work(world, start);
  const Pose up = testing::pose(5e-6, 1e-7, 0);
  work.move(start, up);
  State after = step(world, start, up, 1e-3).state;
  EXPECT_FALSE(work.gained(after));
  after.tip[1] -= 1.01e-7;  // as far behind the hand as before it gave way, and a hundredth more
  EXPECT_TRUE(work.gained(after));
}

}  // namespace
}  // namespace ferrule
