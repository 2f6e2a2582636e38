// What a step does does not depend on how the scene lies about the bore's axis.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "bench/random_scene.hpp"
#include "sim/scene/draw.hpp"
#include "sim/solver/step.hpp"

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

TEST(Invariance, AnyTurnTurnsTheResult) {
  for (const char* name : {"bench", "epoxy", "tight", "sticky", "adhesive", "laser"}) {
    const Scene scene = load_scene(name, {"laws.gravity=null"});
    for (const Motion motion : {Motion::insertion, Motion::press}) {
      EXPECT_LE(difference(scene, quarter_turn, motion), 1e-6) << name;
      for (const double angle : {0.3, 0.65, 2.2}) {
        const auto turned = [&](const Pose& p) {
          const Eigen::Rotation2Dd turn(angle);
          Pose q = p;
          q.segment<2>(1) = turn * p.segment<2>(1);
          q.tail<2>() = turn * p.tail<2>();
          return q;
        };
        EXPECT_LE(difference(scene, turned, motion), 1e-6) << name << " " << angle;
      }
    }
  }
}

// From a row of numbers, as files have it, to the last bit.
TEST(Invariance, GoingOnFromARowOfAStateChangesNothing) {
  for (const char* name : {"bench", "hard", "sticky", "adhesive", "epoxy", "demo", "film"}) {
    const Scene scene = load_scene(name);
    for (const Motion motion : {Motion::insertion, Motion::press}) {
      const State start = draw_start(scene, 3, 1);
      State here = start, there = start;
      int n = 0;
      for (const Pose& hand : commands(scene, start, motion, 1e-3, 3, 1)) {
        here = step(scene.world, here, hand, 1e-3).state;
        there = step(scene.world, there, hand, 1e-3).state;
        if (++n % 97 == 0) there = state_of(to_row(there));
      }
      EXPECT_EQ(to_row(here), to_row(there)) << name;
    }
  }
}

}  // namespace
}  // namespace ferrule
