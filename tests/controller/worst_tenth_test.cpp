#include "controller/worst_tenth.hpp"

#include <gtest/gtest.h>

#include <random>

#include "sim/scene/draw.hpp"

namespace ferrule {
namespace {

std::vector<TrialResult> results_of(const std::vector<bool>& inserted) {
  std::vector<TrialResult> results;
  for (const bool each : inserted)
    results.push_back({each ? Outcome::inserted : Outcome::jam, {}, 0, {}, {}, {}});
  return results;
}

TEST(WorstTenth, IsWhereItFails) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<DrawnQuantity> drawn = {{"no matter", {}}, {"decides", {}}};
  std::vector<bool> inserted;
  for (int k = 0; k < 4000; ++k) {
    for (DrawnQuantity& quantity : drawn) quantity.values.push_back(uniform(random));
    const double rate = drawn[1].values.back() > 0.9 ? 0.3 : 0.9;
    inserted.push_back(uniform(random) < rate);
  }
  const WorstTenth worst = worst_tenth(drawn, results_of(inserted));
  EXPECT_EQ(worst.name, "decides");
  EXPECT_NEAR(worst.low, 0.9, 0.02);
  EXPECT_NEAR(worst.high, 1, 0.01);
  EXPECT_NEAR(static_cast<double>(worst.trials), 200, 40);
  const double rate = static_cast<double>(worst.successes) / static_cast<double>(worst.trials);
  EXPECT_NEAR(rate, 0.3, 4 * std::sqrt(0.3 * 0.7 / 200));
}

// The least of many parts is low by chance; what is told is not.
TEST(WorstTenth, OfWhatNothingDecidesIsTheMean) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::size_t successes = 0, trials = 0;
  for (int campaign = 0; campaign < 200; ++campaign) {
    std::vector<DrawnQuantity> drawn(5);
    std::vector<bool> inserted;
    for (int k = 0; k < 200; ++k) {
      for (DrawnQuantity& quantity : drawn) quantity.values.push_back(uniform(random));
      inserted.push_back(uniform(random) < 0.7);
    }
    const WorstTenth worst = worst_tenth(drawn, results_of(inserted));
    successes += worst.successes;
    trials += worst.trials;
  }
  const double rate = static_cast<double>(successes) / static_cast<double>(trials);
  EXPECT_NEAR(rate, 0.7, 4 * std::sqrt(0.7 * 0.3 / static_cast<double>(trials)));
}

TEST(WorstTenth, TakesWhatTheTrialsWereDrawnWith) {
  const Scene scene =
      load_scene("bench", {"ferrule.bore_diameter_um=125.6..126.4", "fibre.diameter_um=125+-0.3"});
  const auto drawn = drawn_quantities(scene, 5, 40);
  ASSERT_EQ(drawn.size(), 4U);
  EXPECT_EQ(drawn[0].name, "start.lateral_um");
  for (std::size_t k = 0; k < 40; ++k) {
    const auto of_trial = draw_scene(scene, 5, k);
    ASSERT_EQ(static_cast<bool>(of_trial), std::isfinite(drawn[0].values[k])) << k;
    if (!of_trial) continue;
    EXPECT_DOUBLE_EQ(1e-6 * drawn[0].values[k],
                     draw_start(*of_trial, 5, k).tip.segment<2>(1).norm());
    for (std::size_t i : {2U, 3U}) {
      const double diameter = i == 2 ? 2 * of_trial->world.profile.bore_radius
                                     : 2 * of_trial->world.annulus.fibre_radius;
      const bool bore = drawn[i].name == "ferrule.bore_diameter_um";
      EXPECT_EQ(bore, i == 2);
      EXPECT_NEAR(1e-6 * drawn[i].values[k], diameter, 1e-12 * diameter);
    }
  }
}

}  // namespace
}  // namespace ferrule
