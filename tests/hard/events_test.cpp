// Where a fibre touches, snaps and sticks does not depend on the step.
#include <gtest/gtest.h>

#include "bench/random_scene.hpp"
#include "sim/scene/draw.hpp"
#include "sim/solver/step.hpp"

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
  StepResult r(start);
  const State& state = r.state;
  std::vector<PoseVector> tips;
  for (std::size_t n = 0; n < hand.size(); ++n) {
    step_on(scene.world, hand[n], n == 0 ? 0 : kPeriod / parts, r);
    const TermForces friction = forces(scene.world, r)[Term::friction];
    ++seen.steps;
    for (std::size_t place = 0; place < kContactPlaces; ++place) {
      const bool closed = state.contact[place].closed;
      seen.touches += closed;
      seen.open_rubs += !closed && friction[place].force.norm() > 0;
    }
    if (n % static_cast<std::size_t>(parts)) continue;
    tips.emplace_back(state.tip);
  }
  return tips;
}

constexpr int kMostBetween = 2;  // a contact that is pulled lets go in one millisecond or the next

// The milliseconds at which steps of 1 and of 1/8 ms differ.
int apart(const Scene& scene, std::uint64_t k, Seen& seen) {
  const std::vector<PoseVector> coarse = in_and_out(scene, k, 1, seen);
  const std::vector<PoseVector> fine = in_and_out(scene, k, 8, seen);
  EXPECT_EQ(coarse.size(), fine.size());
  int sum = 0;
  for (std::size_t n = 0; n < coarse.size(); ++n)
    sum += (coarse[n] - fine[n]).length() > 0.1 * scene.world.annulus.clearance();
  return sum;
}

TEST(EventsAtLength, AgreeAtAnEighthOfTheStep) {
  Seen seen;
  for (const char* name :
       {"bench", "easy", "medium", "hard", "sloppy", "sticky", "tight", "epoxy", "adhesive"}) {
    const Scene scene = load_scene(name);
    for (std::uint64_t k = 0; k < kStarts; ++k)
      EXPECT_LE(apart(scene, k, seen), kMostBetween) << name << " " << k;
  }
  EXPECT_GT(seen.touches, seen.steps / 10);
  EXPECT_LE(seen.open_rubs, seen.steps / 100000);
}

// In the bore one of two contacts lets go (2), or the end slides out over the edge of the mouth
// (5): the pose at which adhesion holds what is left is a tenth of a nanometre wide.
TEST(EventsAtLength, WhatAdhesionStillHoldsStays) {
  Seen seen;
  for (const char* name : {"laser", "adhesive"})
    for (const std::uint64_t k : {2, 5})
      EXPECT_LE(apart(load_scene(name), k, seen), kMostBetween) << name << " " << k;
}

// Forces of friction along x at the mouth, every millisecond of 0.2 s in which a fibre that is
// pressed against the mouth is pulled out by 3 um, or pushed in.
std::vector<double> friction_at_mouth(const World& world, double way, int parts) {
  const double from = way > 0 ? -2e-6 : 1e-6;
  Pose hand = Pose::Zero();
  hand[0] = from;
  StepResult now(at_rest(world, hand));
  const double aside = 5 * world.annulus.clearance();
  for (int n = 1; n <= 200; ++n) {
    hand[1] = -aside * n / 200;
    step_on(world, hand, kPeriod, now);
  }
  std::vector<double> along;
  for (int n = 1; n <= 200 * parts; ++n) {
    hand[0] = from + way * n / (200 * parts);
    step_on(world, hand, kPeriod / parts, now);
    if (n % parts == 0) along.push_back(forces(world, now)[Term::friction][kSide].force.x());
  }
  return along;
}

// Not a step later: by a twentieth of the force, with 15 nm in a step.
TEST(Events, FrictionAtTheMouthIsOfThePatchThatIsIn) {
  const World world = load_scene("easy").world;
  for (const double way : {3e-6, -3e-6}) {
    const std::vector<double> coarse = friction_at_mouth(world, way, 1);
    const std::vector<double> fine = friction_at_mouth(world, way, 32);
    double largest = 0, off = 0;
    for (std::size_t n = 0; n < fine.size(); ++n) {
      largest = std::max(largest, std::abs(fine[n]));
      off = std::max(off, std::abs(coarse[n] - fine[n]));
    }
    EXPECT_GT(largest, 1e-6);
    EXPECT_LE(off, 0.01 * largest) << way;
  }
}

}  // namespace
}  // namespace ferrule
