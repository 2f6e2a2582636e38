#include "learn/fit_warnings.hpp"

#include <gtest/gtest.h>

#include "insertion/scene_scaling.hpp"

namespace ferrule {
namespace {

TEST(TimeWithoutForce, IsTheWayOverTheSpeed) {
  const Scene scene = load_scene("demo");
  const double motion = scene_scaling(scene).motion;
  const double way = scene.start.distance + scene.success.depth;
  for (const double share : {1.0, 0.5, 3.0}) {  // of the speed limit, which cuts the last
    const double speed = share * scene.limits.speed;
    const double time =
        time_without_force(controller_maker(ConstantVelocity(motion * speed)), scene);
    EXPECT_NEAR(time, way / std::min(speed, scene.limits.speed), 2e-3);
  }
  const double slow = 0.9 * way / scene.limits.time;
  EXPECT_TRUE(
      std::isinf(time_without_force(controller_maker(ConstantVelocity(motion * slow)), scene)));
}

}  // namespace
}  // namespace ferrule
