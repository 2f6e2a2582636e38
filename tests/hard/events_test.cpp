// Where a fibre touches, snaps and sticks does not depend on the step.
#include <gtest/gtest.h>

#include "bench/random_scene.hpp"
#include "sim/scene/draw.hpp"
#include "sim/step.hpp"

namespace ferrule {
namespace {

#if defined(__SANITIZE_ADDRESS__)
constexpr std::uint64_t kStarts = 1;  // the same code, many times slower
#else
constexpr std::uint64_t kStarts = 3;
#endif
constexpr double kPeriod = 1e-3;

struct Seen {
  long steps = 0, touches = 0, open_rubs = 0;  // a contact that has opened still rubs
};

// Into the bore and out of it, wandering sideways and in tilt: poses every millisecond.
std::vector<PoseVector> in_and_out(const Scene& scene, std::uint64_t k, int parts, Seen& seen) {
  const State start = draw_start(scene, 1, k);
  const std::vector<Pose> hand = commands(scene, start, Motion::insertion, kPeriod / parts, 1, k);
  State state = start;
  std::vector<PoseVector> tips;
  for (std::size_t n = 0; n < hand.size(); ++n) {
    const StepResult r = step(scene.world, state, hand[n], n == 0 ? 0 : kPeriod / parts);
    state = r.state;
    ++seen.steps;
    for (std::size_t place = 0; place < kContactPlaces; ++place) {
      const bool closed = state.contact[place].closed;
      seen.touches += closed;
      seen.open_rubs += !closed && r.forces[Term::friction][place].force.norm() > 0;
    }
    if (n % static_cast<std::size_t>(parts)) continue;
    tips.emplace_back(state.tip);
  }
  return tips;
}

// A contact that is pulled lets go in one millisecond or in the next.
TEST(Events, AgreeAtAnEighthOfTheStep) {
  constexpr int kMostBetween = 2;
  Seen seen;
  for (const char* name :
       {"bench", "easy", "medium", "hard", "sloppy", "sticky", "tight", "epoxy", "adhesive"}) {
    const Scene scene = load_scene(name);
    for (std::uint64_t k = 0; k < kStarts; ++k) {
      const std::vector<PoseVector> coarse = in_and_out(scene, k, 1, seen);
      const std::vector<PoseVector> fine = in_and_out(scene, k, 8, seen);
      ASSERT_EQ(coarse.size(), fine.size());
      int apart = 0;
      for (std::size_t n = 0; n < coarse.size(); ++n)
        apart += (coarse[n] - fine[n]).length() > 0.1 * scene.world.annulus.clearance();
      EXPECT_LE(apart, kMostBetween) << name << " " << k;
    }
  }
  EXPECT_GT(seen.touches, seen.steps / 10);
  EXPECT_LE(seen.open_rubs, seen.steps / 100000);
}

}  // namespace
}  // namespace ferrule
