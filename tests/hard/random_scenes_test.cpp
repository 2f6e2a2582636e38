// Random scenes over the whole range of the schema, and hands that jump in them
// (bench/random_scene.hpp): the work of a step is bounded, nothing is ever not finite, and no
// closed motion gains energy.
#include <gtest/gtest.h>

#include "bench/hand_work.hpp"
#include "bench/random_scene.hpp"
#include "sim/scene/draw.hpp"
#include "sim/step.hpp"

namespace ferrule {
namespace {

#if defined(__SANITIZE_ADDRESS__)
constexpr std::uint64_t kScenes = 4;  // the same code, many times slower
#else
constexpr std::uint64_t kScenes = 60;
#endif

TEST(RandomScenes, BoundTheWorkOfAStepAndGainNoEnergy) {
  long steps = 0, unfinished = 0;
  for (std::uint64_t k = 0; k < kScenes; ++k) {
    const Scene scene = random_scene(5, k);
    const World& world = scene.world;
    for (int motion = 0; motion < kMotions; ++motion) {
      State state = draw_start(scene, 5, k);
      HandWork work(world, state);
      for (const Pose& hand :
           commands(scene, state, static_cast<Motion>(motion), 1e-3, 5, k, 1.0)) {
        work.move(state, hand);
        const StepResult r = step(world, state, hand, 1e-3);
        ASSERT_LE(r.evaluations, kMostEvaluations) << k << " " << motion;
        ASSERT_TRUE(to_row(r.state).allFinite() && r.forces.holder.allFinite()) << k;
        ASSERT_EQ(r.state.command, hand) << k;
        state = r.state;
        ++steps;
        unfinished += r.status != StepStatus::ok;
      }
      EXPECT_FALSE(work.gained(state)) << k << " " << motion;
    }
  }
  EXPECT_LT(unfinished, steps / 100);
}

// Capped steps in which the search went millimetres away, or ended higher than it began, and what
// was left there came back to the hand as energy.
TEST(RandomScenes, ASearchThatEndsEarlyDoesNotThrowTheEndAway) {
  struct Case {
    std::uint64_t seed, k;
    Motion motion;
    double dt;
  };
  for (const auto& [seed, k, motion, dt] : {Case{5, 172, Motion::insertion, 1e-4},
                                            {12, 71, Motion::press, 1e-3},
                                            {1, 32, Motion::jumps, 1e-4}}) {
    const Scene scene = random_scene(seed, k);
    State state = draw_start(scene, seed, k);
    HandWork work(scene.world, state);
    for (const Pose& hand : commands(scene, state, motion, dt, seed, k, 4000 * dt)) {
      work.move(state, hand);
      state = step(scene.world, state, hand, dt).state;
    }
    EXPECT_FALSE(work.gained(state)) << seed << " " << k;
  }
}

}  // namespace
}  // namespace ferrule
