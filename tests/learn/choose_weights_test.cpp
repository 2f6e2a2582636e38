#include "learn/choose_weights.hpp"

#include <gtest/gtest.h>

#include "sim/scene/read_scene.hpp"
#include "tests/policies.hpp"

namespace ferrule {
namespace {

// Weights that always answer so [mm/s]: none but the last bias.
Snapshot constant(std::size_t epochs, float forward) {
  Snapshot snapshot{epochs, {}};
  Network& network = snapshot.weights.network;
  network.resize(2);
  network[0].weight.setZero(4, 6);
  network[0].bias.setZero(4);
  network[1].weight.setZero(6, 4);
  network[1].bias.setZero(6);
  network[1].bias[0] = -forward;
  return snapshot;
}

Policy in_mm_per_s() {
  Policy policy = testing::random_policy(1, {4}, 1, 1);
  policy.velocity_mean.setZero();
  policy.velocity_scale.setConstant(1e-3);
  return policy;
}

// A scene in which the fibre needs only be pushed, and one in which that never helps.
Json straight() {
  Json scene = load_scene("demo").document();
  scene["start"]["lateral_sd_um"] = scene["start"]["tilt_sd_mrad"] = 0;
  scene["start"]["lateral_mean_um"] = {0, 0};
  return scene;
}
Json aside() {
  Json scene = straight();
  scene["start"]["lateral_mean_um"] = {60, 0};
  return scene;
}

const auto kGoOn = [] { return true; };

TEST(ChooseWeights, ThoseThatInsertMostOften) {
  const std::vector<Snapshot> all = {constant(10, -1), constant(20, 5), constant(30, 0)};
  const TriedWeights best = choose_weights(all, in_mm_per_s(), {straight()}, 3, 1, kGoOn);
  ASSERT_TRUE(best.tried);
  EXPECT_EQ(best.tried->epochs, 20u);
  EXPECT_EQ(best.inserted, 3u);
}

TEST(ChooseWeights, OfEqualsTheFastest) {
  const std::vector<Snapshot> all = {constant(10, 3), constant(20, 5), constant(30, 4)};
  EXPECT_EQ(choose_weights(all, in_mm_per_s(), {straight()}, 2, 1, kGoOn).tried->epochs, 20u);
}

TEST(ChooseWeights, AllScenesHaveTheirShareOfTheRollouts) {
  const std::vector<Snapshot> one = {constant(10, 5)};
  const std::vector<Json> scenes = {aside(), straight(), straight()};
  EXPECT_EQ(choose_weights(one, in_mm_per_s(), scenes, 7, 1, kGoOn).inserted, 5u);
  EXPECT_EQ(choose_weights(one, in_mm_per_s(), scenes, 2, 1, kGoOn).inserted, 1u)
      << "fewer rollouts than scenes";
}

TEST(ChooseWeights, NoneWhereItIsStopped) {
  int asked = 0;
  const auto stop = [&] { return ++asked < 100; };
  EXPECT_FALSE(choose_weights({constant(10, 5)}, in_mm_per_s(), {straight()}, 50, 1, stop).tried);
}

}  // namespace
}  // namespace ferrule
