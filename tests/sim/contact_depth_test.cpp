#include "sim/contact_depth.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "sim/scene/random.hpp"
#include "sim/scene/scene.hpp"

namespace ferrule {
namespace {

// The rim of the end is as deep in the cone as the deepest of its points, all of them looked at.
TEST(ContactDepth, OnTheConeIsThatOfTheDeepestPointOfTheRim) {
  const World world = load_scene("bench").world;
  const FerruleProfile& profile = world.profile;
  const double r = world.annulus.fibre_radius;
  RandomStream random(4, 0, Draw::plan);
  int on_cone = 0;
  for (int n = 0; n < 200; ++n) {
    State state;
    state.tip << 5e-6 + 50e-6 * random.uniform(), 1e-5 * random.normal(), 1e-5 * random.normal(),
        2e-3 * random.normal(), 2e-3 * random.normal();
    const PoseVector tip(state.tip);
    const auto depth = contact_depths(world, contact_side(world, state), tip)[kEnd];
    double deepest = -INFINITY;
    constexpr int kPoints = 20000;
    for (int i = 0; i < kPoints; ++i) {
      const double angle = 2 * std::numbers::pi * i / kPoints;
      const Vector2d u(std::cos(angle), std::sin(angle));
      // As far from the bore's axis as r + u.e, to first order in e.
      const EdgeDepth point = edge_depth(profile, tip.x - r * u.dot(tip.t), r + u.dot(tip.e));
      deepest = std::max(deepest, point.cone);
    }
    if (depth.value == -INFINITY || depth.edge > 0 || depth.slope[0] == 0) continue;
    ++on_cone;
    EXPECT_NEAR(depth.value, deepest, 1e-12);
  }
  EXPECT_GT(on_cone, 50);
}

}  // namespace
}  // namespace ferrule
