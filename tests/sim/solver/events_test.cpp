#include "sim/solver/events.hpp"

#include <gtest/gtest.h>

#include "sim/scene/scene.hpp"
#include "sim/solver/step.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

using testing::pose;

// A fibre that slides along the bore while it comes nearer to the wall, snaps to it and sticks:
// where along the bore [m] tells when it snapped.
struct Stuck {
  double x = 0;
  int rejected = 0;  // of the step that it snapped in
};
Stuck slides_until_it_sticks(const std::string& event_travel, double way) {
  const Scene scene =
      testing::bare({"roughness_nm=5", "holder.tilt_stiffness_N_m_rad=1e3",
                     "laws.adhesion={\"form\":\"corrected\",\"work_of_adhesion_J_m2\":0.144,"
                     "\"maugis_lambda\":4}",
                     "laws.friction={\"form\":\"corrected\",\"burgers_nm\":0.48}", event_travel});
  State state =
      at_rest(scene.world, pose(-20e-6, scene.world.annulus.clearance() - 60e-9, 0, -2e-3));
  Pose hand = state.command;
  Stuck stuck;
  for (int n = 0; n < 200 * 60e-9 / way && !state.contact[kEnd].closed; ++n) {
    hand[0] -= way;
    hand[1] += way / 60;
    const StepResult r = step(scene.world, state, hand, 1e-3);
    stuck.rejected = r.rejected;
    state = r.state;
  }
  EXPECT_TRUE(state.contact[kEnd].closed);
  stuck.x = state.contact[kEnd].stuck.x();
  return stuck;
}

TEST(EventSearch, LocatesASnapWhereTheSceneAsksForIt) {
  const Stuck coarse = slides_until_it_sticks("event_travel_nm=1e9", 60e-9);
  const Stuck located = slides_until_it_sticks("event_travel_nm=2", 60e-9);
  const Stuck fine = slides_until_it_sticks("event_travel_nm=0.1", 60e-9);
  EXPECT_EQ(coarse.rejected, 0);
  EXPECT_GE(located.rejected, 1);
  EXPECT_GE(fine.rejected, located.rejected);
  EXPECT_LE(std::abs(located.x - fine.x), 2e-9);
  EXPECT_LE(std::abs(coarse.x - fine.x), 60e-9);
  EXPECT_GT(std::abs(coarse.x - fine.x), std::abs(located.x - fine.x));
}

// A step shorter than those that an edge asks for is divided as any other.
TEST(EventSearch, LocatesASnapInShortStepsToo) {
  const double fine = slides_until_it_sticks("event_travel_nm=0.01", 0.1e-9).x;
  for (const double way : {9e-9, 5e-9, 2e-9})
    EXPECT_LE(std::abs(slides_until_it_sticks("event_travel_nm=0.2", way).x - fine), 0.3e-9) << way;
}

// Free of friction, tilted and elastic: the determinant falls as the root of the way that is left
// to the fold at which it snaps to the wall.
TEST(EventSearch, TheStiffnessFallsUpToAFold) {
  const Scene scene = load_scene("bench", {"laws.friction=null", testing::kEveryStepSolved});
  StepResult now(at_rest(scene.world, pose(-30e-6, 0, 0, -1e-3)));
  State& state = now.state;
  const double way = 0.01e-9;
  std::vector<double> determinants;
  for (Pose hand = state.command; !state.contact[kEnd].closed && hand[1] < 1e-6; hand[1] += way) {
    step_on(scene.world, hand, 1e-3, now);
    determinants.push_back(stiffness_determinant(scene.world, now));
  }
  ASSERT_TRUE(state.contact[kEnd].closed);
  const auto n = determinants.size() - 1;  // closed with the last one
  double nearer = 0;
  for (const std::size_t left : {20U, 40U, 80U}) {  // steps of the way
    const double near = determinants[n - left], far = determinants[n - 2 * left];
    ASSERT_LT(near, far);
    const double off = near * near / (far * far - near * near) - 1;  // relative, of the way left
    EXPECT_GT(off, nearer);
    EXPECT_LT(off, 0.015 * static_cast<double>(left));
    nearer = off;
  }
}

}  // namespace
}  // namespace ferrule
