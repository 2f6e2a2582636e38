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

// Into the bore and back to its mouth, wandering sideways and in tilt: poses every millisecond.
std::vector<PoseVector> inside(const Scene& scene, std::uint64_t k, int parts, Seen& seen) {
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
    if (n > hand.size() / 2 && state.tip[0] > -1e-6) break;
  }
  return tips;
}

TEST(Events, AgreeAtAnEighthOfTheStep) {
  Seen seen;
  for (const char* name : {"bench", "sticky", "tight", "epoxy", "adhesive"}) {
    const Scene scene = load_scene(name);
    for (std::uint64_t k = 0; k < kStarts; ++k) {
      const std::vector<PoseVector> coarse = inside(scene, k, 1, seen);
      const std::vector<PoseVector> fine = inside(scene, k, 8, seen);
      const std::size_t count = std::min(coarse.size(), fine.size());
      double most = 0;
      for (std::size_t n = 0; n < count; ++n) most = std::max(most, (coarse[n] - fine[n]).length());
      EXPECT_LE(most, 0.1 * scene.world.annulus.clearance()) << name << " " << k;
      EXPECT_LE(std::max(coarse.size(), fine.size()), count + 2);
    }
  }
  EXPECT_GT(seen.touches, seen.steps / 10);
  EXPECT_LE(seen.open_rubs, seen.steps / 100000);
}

}  // namespace
}  // namespace ferrule
