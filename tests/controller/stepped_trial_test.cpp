#include "controller/stepped_trial.hpp"

#include <gtest/gtest.h>

#include "insertion/scene_scaling.hpp"
#include "tests/controller/law.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

std::shared_ptr<const Scene> noisy(const std::vector<std::string>& more = {}) {
  std::vector<std::string> settings{"start.lateral_sd_um=6", "start.distance_um=20",
                                    "success.depth_um=10", "limits.force_uN=3",
                                    "sensor={\"noise_uN\":0.01,\"bias_uN\":0.01,"
                                    "\"bandwidth_Hz\":200,\"resolution_uN\":0.001}"};
  settings.insert(settings.end(), more.begin(), more.end());
  return std::make_shared<Scene>(testing::paper(settings));
}

void expect_same_trials(const std::shared_ptr<const Scene>& scene) {
  for (std::uint64_t trial = 0; trial < 6; ++trial) {
    Law inside = kLaw, outside = kLaw;
    const TrialResult run = run_trial(*scene, inside, 5, trial);
    SteppedTrial stepped(scene, 5, trial);
    while (!stepped.ended()) stepped.step(outside.command(stepped.observation()));
    EXPECT_EQ(stepped.ended()->outcome, run.outcome);
    EXPECT_EQ(stepped.ended()->summary.time, run.summary.time);
    EXPECT_EQ(stepped.ended()->summary.peak_force, run.summary.peak_force);
    EXPECT_EQ(stepped.ended()->summary.friction_work, run.summary.friction_work);
    EXPECT_EQ(stepped.ended()->summary.offset, run.summary.offset);
  }
}

// Whoever answers, the trial is the same, to the last bit.
TEST(SteppedTrial, HasTheBitsOfATrialThatItsControllerRuns) {
  expect_same_trials(noisy());
}

TEST(SteppedTrial, HasThemWhereTheEntranceIsTakenToBeElsewhereAndTheFibreIsCurled) {
  expect_same_trials(noisy({"sensor.entrance_sd_um=4", "fibre.curl_radius_m=2"}));
}

TEST(SteppedTrial, IsCutToTheSpeedLimitAndStaysAsItEnded) {
  const auto scene = noisy();
  SteppedTrial trial(scene, 1, 1);
  HandTwist fast = HandTwist::Zero();
  fast[0] = -1;
  const double start = trial.result().state.command[0];
  trial.step(fast);
  EXPECT_NEAR(trial.result().state.command[0], start - 1e-3 * scene->limits.speed, 1e-18);
  trial.step(HandTwist::Constant(std::numeric_limits<double>::quiet_NaN()));
  ASSERT_TRUE(trial.ended());
  EXPECT_EQ(trial.ended()->outcome, Outcome::invalid_output);
  const double ended = trial.time();
  trial.step(fast);
  EXPECT_EQ(trial.time(), ended);
}

TEST(SteppedTrial, OfPartsThatDoNotFitHasEndedAsInfeasible) {
  const auto scene = std::make_shared<Scene>(
      testing::paper({"tolerance={\"fibre_diameter_sd_um\":0,\"bore_diameter_um\":[120,121]}"}));
  const SteppedTrial trial(scene, 1, 1);
  ASSERT_TRUE(trial.ended());
  EXPECT_EQ(trial.ended()->outcome, Outcome::infeasible);
}

}  // namespace
}  // namespace ferrule
