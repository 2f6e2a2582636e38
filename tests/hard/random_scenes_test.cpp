// Random scenes over the whole range of the schema, and hands that jump in them
// (bench/random_scene.hpp): the work of a step is bounded, nothing is ever not finite, and no
// closed motion gains energy.
#include <gtest/gtest.h>

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

constexpr std::uint64_t kSeed = 5;
constexpr double kStepTime = 1e-3;  // [s]

struct Steps {
  long all = 0, unfinished = 0;
};

void follow_closed_motion(std::uint64_t k, Motion motion, Steps& steps) {
  SCOPED_TRACE(::testing::Message() << k << " " << name(motion));
  const Scene scene = random_scene(kSeed, k);
  const World& world = scene.world;
  StepResult r(draw_start(scene, kSeed, k));
  const State& state = r.state;
  HandWork work(world, state);
  for (const Pose& hand : commands(scene, state, motion, kStepTime, kSeed, k, 1)) {
    work.move(state, hand);
    step_on(world, hand, kStepTime, r);
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
      ASSERT_NO_FATAL_FAILURE(follow_closed_motion(k, static_cast<Motion>(motion), steps));
  EXPECT_LT(steps.unfinished, steps.all / 100);
}

}  // namespace
}  // namespace ferrule
