#include "learn/improve.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/base/error.hpp"
#include "tests/compare.hpp"

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
  EXPECT_TRUE(std::isnan(Objective{}.of({trials[2]})));
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
      EXPECT_STRNE(gain_name(search, i), size);
}

Scene short_insertion() {
  Json document = load_scene("bench").document;
  document["start"]["distance_um"] = 10;
  document["start"]["lateral_sd_um"] = 4;
  document["success"]["depth_um"] = 8;
  return parse_scene(document, "short");
}

TEST(Improve, InsertsSoonerInTrialsThatItHasNotSeen) {
  const ControllerFile before = read_controller("tuned_by_hand");
  const Scene scene = short_insertion();
  const auto cost = [&](const ControllerFile& file) {
    return Objective{.time = 1}.of(run_campaign(scene, maker(file), 5, 40, 0, {}));
  };
  ImproveSettings settings{.trials = 2500, .trials_each = 8, .seed = 2, .threads = 2};
  const Improved improved = improve(before, scene, {.time = 1}, settings);
  EXPECT_LE(improved.trials, settings.trials);
  EXPECT_LT(cost(improved.controller), 0.8 * cost(before));

  // The same with one thread.
  settings.threads = 1;
  const Improved again = improve(before, scene, {.time = 1}, settings);
  for (const std::size_t i : free_gains(before))
    EXPECT_EQ(gain(improved.controller, i), gain(again.controller, i));
}

TEST(Improve, KeepsTheBestWhereItIsStopped) {
  const ControllerFile before = read_controller("tuned_by_hand");
  int rows = 0;
  const Improved improved = improve(
      before, short_insertion(), {.time = 1}, {.trials = 2500, .trials_each = 4},
      [&](const ImproveRow&) { ++rows; }, [&] { return rows == 3; });
  EXPECT_EQ(improved.rows.size(), 3U);
  EXPECT_NE(gain(improved.controller, 0), gain(before, 0));
}

}  // namespace
}  // namespace ferrule
