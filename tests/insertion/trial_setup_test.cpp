#include "insertion/trial_setup.hpp"

#include <gtest/gtest.h>

#include "insertion/scene_scaling.hpp"
#include "sim/scene/draw.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

// What the sensor reads of nothing, ten times: its bias and its noise.
std::vector<Wrench> readings(ForceSensor sensor) {
  std::vector<Wrench> all;
  for (int n = 0; n < 10; ++n) all.push_back(sensor.read(Wrench::Zero(), 1e-3));
  return all;
}

TEST(TrialSetup, IsWhatIsDrawnForTheTrial) {
  const Scene scene = load_scene(
      "bench", {"ferrule.bore_diameter_um=126..127", "sensor.noise_uN=1", "sensor.bias_uN=1"});
  const auto setup = trial_setup(scene, 3, 5);
  ASSERT_TRUE(setup);
  EXPECT_EQ(setup->scene->document(), draw_scene(scene, 3, 5)->document());
  EXPECT_EQ(setup->start.tip, draw_start(scene, 3, 5).tip);
  EXPECT_EQ(readings(setup->sensor), readings(ForceSensor(scene.sensor, 3, 5)));
  EXPECT_EQ(setup->hand(), scene_scaling(scene).motion_to_hand(setup->start.command));
}

TEST(TrialSetup, OfARecordingIsThatOfItsTrial) {
  const Scene scene = load_scene("bench", {"ferrule.bore_diameter_um=126..127"});
  const auto setup = trial_setup(scene, 3, 5);
  const Scene recorded = parse_scene(setup->scene->document(), "recorded");
  const auto again = trial_setup(recorded, 3, 5);
  EXPECT_EQ(again->scene.get(), &recorded);
  EXPECT_EQ(again->start.tip, setup->start.tip);
  EXPECT_EQ(readings(again->sensor), readings(setup->sensor));
}

TEST(TrialSetup, OnlyWhatIsRedrawnChanges) {
  const Scene scene = load_scene(
      "bench", {"ferrule.bore_diameter_um=126..127", "sensor.noise_uN=1", "sensor.bias_uN=1"});
  const auto as_it_is = trial_setup(scene, 3, 5);
  for (const char* key : {"sensor", "ferrule.bore_diameter_um", "start.lateral_sd_um"}) {
    const auto again = trial_setup(scene, 3, 5, key);
    const auto redrawn = [&](const char* what) { return std::string(what) == key; };
    EXPECT_NE(readings(again->sensor) == readings(as_it_is->sensor), redrawn("sensor")) << key;
    EXPECT_NE(again->scene->parameters.ferrule.bore_diameter_um ==
                  as_it_is->scene->parameters.ferrule.bore_diameter_um,
              redrawn("ferrule.bore_diameter_um"))
        << key;
    EXPECT_NE(again->start.tip[1] == as_it_is->start.tip[1], redrawn("start.lateral_sd_um")) << key;
  }
}

TEST(TrialSetup, IsEmptyWhereThePartsCannotBeTogether) {
  const Scene scene = testing::paper({"ferrule.bore_diameter_um=124.8..125.4"});
  std::size_t infeasible = 0;
  for (std::uint64_t trial = 0; trial < 40; ++trial) {
    const auto setup = trial_setup(scene, 1, trial);
    EXPECT_EQ(setup.has_value(), draw_scene(scene, 1, trial) != nullptr) << trial;
    infeasible += !setup;
    const TrialSetup feasible = feasible_setup(scene, 1, trial);
    const FeasibleTrial drawn = feasible_trial(scene, 1, trial);
    EXPECT_EQ(feasible.trial, drawn.trial);
    EXPECT_EQ(feasible.infeasible, drawn.infeasible);
    EXPECT_EQ(feasible.scene->document(), drawn.scene->document());
    EXPECT_EQ(feasible.infeasible == 0, setup.has_value()) << trial;
  }
  EXPECT_GT(infeasible, 0u);
  EXPECT_LT(infeasible, 40u);
}

}  // namespace
}  // namespace ferrule
