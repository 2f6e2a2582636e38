#include "learn/improve.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/base/error.hpp"
#include "tests/compare.hpp"
#include "tests/policies.hpp"

namespace ferrule {
namespace {

TrialResult ended(Outcome outcome, double time, double force) {
  TrialResult trial{};
  trial.outcome = outcome;
  trial.summary.time = time;
  trial.summary.peak_force = force;
  return trial;
}

TEST(Improve, AFailureCostsTenInsertionsAndTheInfeasibleCountsForNobody) {
  const std::vector<TrialResult> trials = {ended(Outcome::inserted, 8, 2e-6),
                                           ended(Outcome::jam, 3, 9e-6),
                                           ended(Outcome::infeasible, 0, 0)};
  EXPECT_DOUBLE_EQ((Objective{.time = 16, .force = 4e-6}.of(trials)), (0.5 + 0.5 + 10) / 2);
  EXPECT_DOUBLE_EQ((Objective{.time = 16}.of(trials)), (0.5 + 10) / 2);
  EXPECT_DOUBLE_EQ(Objective{}.of(trials), 5);
  EXPECT_TRUE(std::isnan(Objective{}.of(std::vector{trials[2]})));
}

TEST(Improve, ChangesTheGainsThatTheControllerHas) {
  const ControllerFile law = read_controller("tuned_by_hand");
  const std::vector<std::size_t> free = free_gains(law);
  for (const std::size_t i : free) EXPECT_NE(gain(law, i), 0) << gain_name(law, i);
  const ControllerFile changed =
      with_gains(law, free, Eigen::VectorXd::Constant(static_cast<Eigen::Index>(free.size()), 1));
  for (std::size_t i = 0; i < kGains; ++i)
    EXPECT_CLOSE(gain(changed, i), std::exp(1) * gain(law, i), 1e-14);

  const ControllerFile search = read_controller("search");
  for (const std::size_t i : free_gains(search))
    for (const char* size : {"fibre_radius", "bore_radius", "mouth_radius", "lead_in_length"})
      EXPECT_NE(gain_name(search, i), size);
}

// Its weights stay. Twice the scale of an input is half of what it says.
TEST(Improve, ChangesTheScalesOfANetwork) {
  PolicyFile file = testing::random_policy_file();
  file.policy.mean.fill(0);
  file.policy.speed_limit = 1;
  const ControllerFile network = file;
  const std::vector<std::size_t> free = free_gains(network);
  ASSERT_EQ(free.size(), 3U + 3U + kPolicyChannels);
  EXPECT_EQ(gain_name(network, 0), "velocity_x mean");
  EXPECT_EQ(gain_name(network, 4), "velocity_y scale");
  EXPECT_EQ(gain_name(network, 6), "force_x scale");
  Eigen::VectorXd x = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(free.size()));
  x.head<6>().setConstant(std::log(3.0));
  x.tail<kPolicyChannels>().setConstant(std::log(2.0));
  PolicyController before(file.policy),
      after(std::get<PolicyFile>(with_gains(network, free, x)).policy);
  RandomStream random(1, 0, Draw::plan);
  for (int n = 0; n < 20; ++n) {
    Observation o = testing::random_observation(random);
    const HandTwist v = before.command(o);
    o.wrench *= 2;
    o.depth *= 2;
    EXPECT_LT((after.command(o) - 3 * v).norm(), 1e-6 * v.norm());
  }
}

Scene short_insertion(const std::string& name = "bench") {
  Json document = load_scene(name).document();
  document["start"]["distance_um"] = 10;
  document["start"]["lateral_sd_um"] = 4;
  document["success"]["depth_um"] = 8;
  return parse_scene(document, "short");
}

TEST(ImproveInSeconds, InsertsSoonerInTrialsThatItHasNotSeen) {
  const ControllerFile before = read_controller("tuned_by_hand");
  const Scene scene = short_insertion();
  const auto cost = [&](const ControllerFile& file) {
    return Objective{.time = 1}.of(run_campaign(scene, maker(file), 5, 40, 0, {}));
  };
  ImproveSettings settings{.trials = 2500, .trials_each = 8, .seed = 2, .threads = 2};
  const Improved improved = improve(before, {{&scene, {.time = 1}}}, settings);
  EXPECT_LE(improved.trials, settings.trials);
  EXPECT_LT(cost(improved.controller), 0.8 * cost(before));

  // What chose it tells it from where it began.
  ASSERT_GE(improved.choice.size(), 2U);
  EXPECT_TRUE(improved.choice.front().before);
  EXPECT_GT(improved.choice.front().above_chosen.low, 0.2);
  int chosen = 0;
  for (const ImproveCentre& centre : improved.choice) {
    EXPECT_LE(centre.above_chosen.low, centre.above_chosen.high);
    EXPECT_GE(centre.above_chosen.low + centre.above_chosen.high, 0);
    if (!centre.chosen) continue;
    ++chosen;
    EXPECT_EQ(centre.above_chosen.low, 0);
    EXPECT_EQ(centre.above_chosen.high, 0);
  }
  EXPECT_EQ(chosen, 1);

  // The same with one thread.
  settings.threads = 1;
  const Improved again = improve(before, {{&scene, {.time = 1}}}, settings);
  for (const std::size_t i : free_gains(before))
    EXPECT_EQ(gain(improved.controller, i), gain(again.controller, i));
}

TEST(ImproveInSeconds, TheSameSceneTwiceIsThatScene) {
  const ControllerFile before = read_controller("tuned_by_hand");
  const Scene scene = short_insertion();
  const ImproveTask task{&scene, {.time = 1}};
  const Improved once = improve(before, {task}, {.trials = 1200, .trials_each = 4});
  const Improved twice = improve(before, {task, task}, {.trials = 2400, .trials_each = 4});
  EXPECT_EQ(twice.trials, 2 * once.trials);
  for (const std::size_t i : free_gains(before))
    EXPECT_EQ(gain(once.controller, i), gain(twice.controller, i));
  // Trials that are the same twice say no more than once.
  ASSERT_EQ(once.choice.size(), twice.choice.size());
  for (std::size_t i = 0; i < once.choice.size(); ++i)
    EXPECT_CLOSE(once.choice[i].above_chosen.low, twice.choice[i].above_chosen.low, 1e-12);
}

TEST(Improve, KeepsTheBestWhereItIsStopped) {
  const ControllerFile before = read_controller("tuned_by_hand");
  int rows = 0;
  const Scene scene = short_insertion();
  const Improved improved = improve(
      before, {{&scene, {.time = 1}}}, {.trials = 2500, .trials_each = 4},
      [&](const ImproveRow&) { ++rows; }, [&] { return rows == 3; });
  EXPECT_EQ(improved.rows.size(), 3U);
  EXPECT_NE(gain(improved.controller, 0), gain(before, 0));
}

}  // namespace
}  // namespace ferrule
