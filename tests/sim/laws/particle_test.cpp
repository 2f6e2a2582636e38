#include "sim/laws/particle.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "sim/scene/draw.hpp"
#include "tests/compare.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

constexpr double kMedian = 0.3e-6, kSpread = 0.8;

std::string dust(double number) {
  return "laws.particle={\"form\":\"corrected\",\"median_um\":0.3,\"spread\":0.8,\"number\":" +
         std::to_string(number) + "}";
}

// The chance that of N on average none is higher.
double none_higher(double number, double height) {
  const double z = std::log(height / kMedian) / kSpread;
  return std::exp(-number * 0.5 * std::erfc(z / std::numbers::sqrt2));
}

TEST(ParticleInSeconds, TheHighestIsThatOfAPoissonNumberOfLogNormalOnes) {
  constexpr int kTrials = 6000;
  for (const double number : {0.3, 1.5, 40.0}) {
    const Scene scene = load_scene("bench", {dust(number)});
    std::vector<double> heights;
    double sum = 0, squares = 0;
    for (std::uint64_t trial = 0; trial < kTrials; ++trial) {
      const auto drawn = draw_scene(scene, 3, trial);
      const auto& there = drawn->world.laws.particle;
      const double h = there ? there->height : 0;
      EXPECT_EQ(h, drawn->parameters.laws.particle->height);
      heights.push_back(h);
      sum += h / kTrials;
      squares += h * h / kTrials;
    }
    const auto share_up_to = [&](double height) {
      return static_cast<double>(std::count_if(heights.begin(), heights.end(),
                                               [&](double h) { return h <= height; })) /
             kTrials;
    };
    const double error = 4 / std::sqrt(kTrials);
    EXPECT_NEAR(share_up_to(0), std::exp(-number), error) << number;
    for (const double height : {0.1e-6, 0.3e-6, 0.5e-6, 1e-6, 2e-6})
      EXPECT_NEAR(share_up_to(height), none_higher(number, height), error) << number;
    // The mean, by its distribution.
    double mean = 0;
    constexpr double kSlice = 1e-9;
    for (double h = 0.5 * kSlice; h < 60e-6; h += kSlice)
      mean += kSlice * (1 - none_higher(number, h));
    EXPECT_NEAR(sum, mean, error * std::sqrt(squares - sum * sum)) << number;
  }
}

TEST(Particle, LiesAnywhereOnTheWall) {
  const Scene scene = load_scene("bench", {dust(50)});
  double place = 0;
  Vector2d direction = Vector2d::Zero();
  constexpr int kTrials = 4000;
  for (std::uint64_t trial = 0; trial < kTrials; ++trial) {
    const auto drawn = draw_scene(scene, 3, trial);
    const Particle& there = *drawn->world.laws.particle;
    EXPECT_GE(there.depth, shallowest(there.height, 0, std::tan(std::numbers::pi / 6)));
    EXPECT_LE(there.depth, scene.success.depth);
    EXPECT_CLOSE(there.outward.norm(), 1, 1e-12);
    place += there.depth / kTrials;
    direction += there.outward / kTrials;
  }
  EXPECT_CLOSE(place, 0.5 * scene.success.depth, 0.04);
  EXPECT_LT(direction.norm(), 0.05);
}

TEST(Particle, WhatIsDrawnIsStated) {
  for (const char* name : {"bench", "tolerance"}) {
    const Scene scene = load_scene(name, {dust(2), "ferrule.ovality_um=0.1", "fibre.edge_um=2"});
    const FeasibleTrial trial = feasible_trial(scene, 4, 9);
    const auto& drawn = trial.scene;
    EXPECT_EQ(undrawn(drawn->document()), scene.document());
    const Scene again = parse_scene(drawn->document(), "drawn");
    const Particle &here = *drawn->world.laws.particle, &there = *again.world.laws.particle;
    EXPECT_EQ(here.height, there.height);
    EXPECT_EQ(here.depth, there.depth);
    EXPECT_EQ(here.outward, there.outward);
    EXPECT_EQ(here.reduced_modulus, there.reduced_modulus);
    EXPECT_EQ(draw_scene(again, 4, trial.trial).get(), &again);
  }
}

TEST(Particle, OfOthersTheDrawsAreAsTheyWere) {
  const char* tolerance = "tolerance";
  const auto clean = draw_scene(load_scene(tolerance), 5, 1);
  const auto dirty = draw_scene(load_scene(tolerance, {dust(1)}), 5, 1);
  EXPECT_EQ(clean->world.annulus.bore_radius, dirty->world.annulus.bore_radius);
  EXPECT_EQ(draw_start(*clean, 5, 1).tip, draw_start(*dirty, 5, 1).tip);
}

TEST(Particle, IsSeldomHigherThanUnusuallyHigh) {
  for (const double number : {1e-3, 0.02, 0.1, 1.0, 30.0, 1000.0}) {
    const Particle law{.number = number, .median = kMedian, .spread = kSpread};
    EXPECT_GE(none_higher(number, unusual_height(law)), 0.98) << number;
    EXPECT_GE(unusual_height(law), kMedian);
  }
  EXPECT_EQ(unusual_height({.number = 0, .median = kMedian, .spread = kSpread}), 0);
  EXPECT_EQ(unusual_height({.number = 3, .median = kMedian, .height = 1e-7}), 1e-7);
  // Before it is drawn a fibre passes it.
  EXPECT_CLOSE(load_scene("bench", {dust(30)}).world.laws.particle->height, 0.5e-6, 1e-12);
  EXPECT_FALSE(load_scene("bench", {dust(0)}).world.laws.particle);
  // Of any spread none is higher than a scene may state.
  EXPECT_EQ(unusual_height({.number = 1000, .median = 100e-6, .spread = 3}), kHighestParticle);
}

TEST(Particle, OneThatIsNotInTheBoreIsRefused) {
  const auto stated = [](const std::string& at) {
    return testing::bare(
        {"laws.particle={\"form\":\"corrected\",\"height_um\":0.5,\"direction_deg\":0,"
         "\"at_um\":" +
         at + "}"});
  };
  EXPECT_NO_THROW(stated("0.7072"));
  EXPECT_THROW(stated("0.7070"), BadInput);
  EXPECT_THROW(testing::bare({"laws.particle={\"form\":\"corrected\",\"height_um\":0.5}"}),
               BadInput);
  EXPECT_THROW(testing::bare({"laws.particle={\"form\":\"printed\",\"number\":1}"}), BadInput);
  EXPECT_THROW(testing::bare({dust(1), "laws.particle.at_um=5"}), BadInput);
  EXPECT_THROW(testing::bare({dust(-1)}), BadInput);
}

}  // namespace
}  // namespace ferrule
