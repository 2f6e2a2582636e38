// What a step does does not depend on how the scene lies about the bore's axis.
#include <gtest/gtest.h>

#include "bench/random_scene.hpp"
#include "sim/scene/draw.hpp"
#include "sim/step.hpp"

namespace ferrule {
namespace {

Pose quarter_turn(const Pose& p) {
  Pose q;
  q << p[0], -p[2], p[1], -p[4], p[3];
  return q;
}

Pose mirrored(const Pose& p) {
  Pose q;
  q << p[0], p[1], -p[2], p[3], -p[4];
  return q;
}

// The largest distance of the end from where it should be [clearances].
template <class Map>
double difference(const Scene& scene, const Map& map, Motion motion) {
  const State start = draw_start(scene, 3, 0);
  State here = start, there = start;
  there.tip = map(start.tip);
  there.command = map(start.command);
  double most = 0;
  for (const Pose& hand : commands(scene, start, motion, 1e-3, 3, 0)) {
    here = step(scene.world, here, hand, 1e-3).state;
    there = step(scene.world, there, map(hand), 1e-3).state;
    const Pose off = map(here.tip) - there.tip;
    most = std::max(most, off.head<3>().norm());
  }
  return most / scene.world.annulus.clearance();
}

TEST(Invariance, AMirroredSceneIsTheMirrorImageToTheLastBit) {
  for (const char* name :
       {"bench", "epoxy", "sticky", "tight", "demo", "paper", "film", "adhesive"}) {
    const Scene scene = load_scene(name);
    for (const Motion motion : {Motion::insertion, Motion::press})
      EXPECT_EQ(difference(scene, mirrored, motion), 0) << name;
  }
}

TEST(Invariance, AQuarterTurnTurnsTheResult) {
  for (const char* name : {"bench", "epoxy", "tight"}) {
    const Scene scene = load_scene(name, {"laws.gravity=null"});
    for (const Motion motion : {Motion::insertion, Motion::press})
      EXPECT_LE(difference(scene, quarter_turn, motion), 1e-6) << name;
  }
}

}  // namespace
}  // namespace ferrule
