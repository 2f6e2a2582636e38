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

// Success at a rate of p(x), uniform x: the share is the variance of the rate over that of success.
TEST(Deciding, IsTheQuantityThatTheRateFollows) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (const double slope : {0.2, 0.6, 1.0}) {
    std::vector<DrawnQuantity> drawn = {{"no matter", {}}, {"decides", {}}, {"neither", {}}};
    std::vector<bool> inserted;
    for (int k = 0; k < 40000; ++k) {
      for (DrawnQuantity& quantity : drawn) quantity.values.push_back(uniform(random));
      inserted.push_back(uniform(random) < 0.5 + slope * (drawn[1].values.back() - 0.5));
    }
    const Deciding found = deciding_quantity(drawn, results_of(inserted));
    EXPECT_EQ(found.name, "decides");
    // Of tenths: 0.99 of the variance slope^2 / 12, over 1 / 4.
    EXPECT_NEAR(found.share, 0.99 * slope * slope / 3, 0.01);
    ASSERT_EQ(found.tenths.size(), 10U);
    for (std::size_t i = 0; i < 10; ++i) {
      const Tenth& tenth = found.tenths[i];
      EXPECT_EQ(tenth.trials, 4000U);
      const double rate = 0.5 + slope * (0.1 * (static_cast<double>(i) + 0.5) - 0.5);
      EXPECT_NEAR(static_cast<double>(tenth.successes) / 4000, rate, 4 * 0.5 / std::sqrt(4000));
      EXPECT_NEAR(tenth.low, 0.1 * static_cast<double>(i), 0.01);
    }
  }
}

// Its share is 0 on average; of one quantity it is told in about half of all campaigns.
TEST(Deciding, IsNothingWhereChanceAloneDecides) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> uniform(0, 1);
  double sum = 0;
  for (int campaign = 0; campaign < 400; ++campaign) {
    std::vector<DrawnQuantity> drawn = {{"no matter", {}}};
    std::vector<bool> inserted;
    for (int k = 0; k < 100; ++k) {
      drawn[0].values.push_back(uniform(random));
      inserted.push_back(uniform(random) < 0.7);
    }
    sum += deciding_quantity(drawn, results_of(inserted)).share;
  }
  // The positive part of a mean of nine squares less 1, times 9/99: 0.017, one of them 0.027.
  EXPECT_NEAR(sum / 400, 0.017, 0.006);
  const std::vector<DrawnQuantity> drawn = {{"x", {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}}};
  for (const bool each : {false, true})
    EXPECT_EQ(deciding_quantity(drawn, results_of(std::vector<bool>(12, each))).name, "");
  EXPECT_EQ(deciding_quantity({{"x", {1, 2}}}, results_of({true, false})).name, "");
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
