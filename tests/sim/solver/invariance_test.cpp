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
  StepResult here(start), there = here;
  there.state.tip = map(start.tip);
  there.state.command = map(start.command);
  double most = 0;
  for (const Pose& hand : commands(scene, start, motion, 1e-3, 3, 0)) {
    step_on(scene.world, hand, 1e-3, here);
    step_on(scene.world, map(hand), 1e-3, there);
    const Pose off = map(here.state.tip) - there.state.tip;
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

}  // namespace
}  // namespace ferrule
