// Random scenes over the whole range of the schema, and hands that jump in them
// (bench/random_scene.hpp): the work of a step is bounded, nothing is ever not finite, and no
// closed motion gains energy.
#include <gtest/gtest.h>

#include "bench/random_scene.hpp"
#include "sim/scene/draw.hpp"
#include "tests/hard/follow.hpp"

namespace ferrule {
namespace {

#if defined(__SANITIZE_ADDRESS__)
constexpr std::uint64_t kScenes = 4;  // the same code, many times slower
#else
constexpr std::uint64_t kScenes = 60;
#endif

constexpr std::uint64_t kSeed = 5;
constexpr double kStepTime = 1e-3;  // [s]

TEST(RandomScenesInSeconds, BoundTheWorkOfAStepAndGainNoEnergy) {
  long all = 0, unfinished = 0;
  for (std::uint64_t k = 0; k < kScenes; ++k) {
    const Scene scene = random_scene(kSeed, k);
    const State start = draw_start(scene, kSeed, k);
    for (const Motion motion : {Motion::insertion, Motion::press, Motion::jumps}) {
      SCOPED_TRACE(::testing::Message() << k << " " << name(motion));
      const auto hand = commands(scene, start, motion, kStepTime, kSeed, k, 1);
      ASSERT_NO_FATAL_FAILURE(testing::follow(scene.world, start, hand, kStepTime, unfinished));
      all += static_cast<long>(hand.size());
    }
  }
  EXPECT_LT(unfinished, all / 100);
}

}  // namespace
}  // namespace ferrule
