// Random scenes over the whole range of the schema, and hands that jump in them
// (bench/random_scene.hpp): the work of a step is bounded, nothing is ever not finite, and no
// closed motion gains energy.
#include <gtest/gtest.h>

#include <tuple>

#include "bench/random_scene.hpp"
#include "sim/analysis/hand_work.hpp"
#include "sim/scene/draw.hpp"
#include "sim/solver/step.hpp"

namespace ferrule {
namespace {

#if defined(__SANITIZE_ADDRESS__)
constexpr std::uint64_t kScenes = 4;  // the same code, many times slower
#else
constexpr std::uint64_t kScenes = 60;
#endif

struct Steps {
  long all = 0, unfinished = 0;
};

void follow_closed_motion(std::uint64_t seed, std::uint64_t k, Motion motion, double dt,
                          double longest, Steps& steps) {
  SCOPED_TRACE(::testing::Message() << seed << " " << k << " " << name(motion));
  const Scene scene = random_scene(seed, k);
  const World& world = scene.world;
  StepResult r(draw_start(scene, seed, k));
  const State& state = r.state;
  HandWork work(world, state);
  for (const Pose& hand : commands(scene, state, motion, dt, seed, k, longest)) {
    work.move(state, hand);
    step_on(world, hand, dt, r);
    ASSERT_LE(r.evaluations, SolverParameters{}.max_evaluations);
    ASSERT_TRUE(to_row(state).allFinite() && r.holder.allFinite());
    ASSERT_EQ(state.command, hand);
    ++steps.all;
    steps.unfinished += r.status != StepStatus::ok;
  }
  EXPECT_FALSE(work.gained(state));
}

TEST(RandomScenes, BoundTheWorkOfAStepAndGainNoEnergy) {
  Steps steps;
  for (std::uint64_t k = 0; k < kScenes; ++k)
    for (int motion = 0; motion < kMotions; ++motion)
      ASSERT_NO_FATAL_FAILURE(
          follow_closed_motion(5, k, static_cast<Motion>(motion), 1e-3, 1.0, steps));
  EXPECT_LT(steps.unfinished, steps.all / 100);
}

// Capped steps in which the search went millimetres away, or ended higher than it began, and what
// was left there came back to the hand as energy.
TEST(RandomScenes, ASearchThatEndsEarlyDoesNotThrowTheEndAway) {
  Steps steps;
  follow_closed_motion(5, 172, Motion::insertion, 1e-4, 0.4, steps);
  follow_closed_motion(12, 71, Motion::press, 1e-3, 4, steps);
}

// Hands that jump over the mouth from the face: off it, bore and cone were not looked at, and a
// search that ended deep in them had the end wedged there; over the mouth's edge it was higher than
// on the face.
TEST(RandomScenes, AnEndThatFallsOffTheFaceIsNotWedgedInTheFerrule) {
  Steps steps;
  for (const auto& [seed, k, dt] :
       {std::tuple{1, 81, 1e-3}, {4, 141, 1e-3}, {6, 157, 1e-4}, {11, 16, 1e-3}, {11, 77, 1e-4}})
    follow_closed_motion(seed, k, Motion::jumps, dt, 4000 * dt, steps);
}

}  // namespace
}  // namespace ferrule
