#include "learn/free_course.hpp"

#include <gtest/gtest.h>

#include "haptic/trainee.hpp"
#include "learn/candidates.hpp"
#include "learn/fit_law.hpp"
#include "learn/fit_warnings.hpp"
#include "learn/record_again.hpp"
#include "tests/compare.hpp"
#include "tests/demonstrations.hpp"

namespace ferrule {
namespace {

constexpr double kYieldY = 8e-4, kYieldZ = 5e-4;  // [m/(s N)]

// Episodes of who yields so, beside a course that no law has: he presses from half of the depth on.
std::vector<Samples> episodes_with(double press, double noise) {
  const DemonstrationSet set = testing::demonstrations(
      [&](const Eigen::Vector3d& f, double depth, double) {
        return Eigen::Vector3d(-3e-3, kYieldY * f.y() - press * std::max(0.0, depth - 0.015),
                               kYieldZ * f.z());
      },
      0.01, 6, 0, noise);
  std::vector<Samples> all;
  for (const Demonstration& d : set.demonstrations) all.push_back(samples(d, 0));
  for (Samples& episode : all)
    for (Sample& sample : episode) sample.height = -sample.depth;
  return all;
}

std::size_t place(LawKind kind, std::string_view name) {
  const auto table = gain_table(kind);
  return static_cast<std::size_t>(
      std::find_if(table.begin(), table.end(), [&](const Gain& g) { return g.name == name; }) -
      table.begin());
}

TEST(FreeCourse, FindsTheYieldsWhateverTheCourse) {
  for (const LawKind kind : {LawKind::linear, LawKind::insertion}) {
    const std::vector<double> gains(gain_table(kind).size(), 1);
    const FreeCourse free = free_course(kind, gains, episodes_with(1, 0));
    EXPECT_CLOSE(free.yields[place(kind, "yield_z")].value, kYieldZ, 1e-9);
    EXPECT_CLOSE(free.yields[place(kind, "yield_y")].value, kYieldY, 2e-3);  // of the kink
    EXPECT_TRUE(std::isnan(free.yields[place(kind, "yield_x")].value));
    EXPECT_TRUE(std::isnan(free.yields[0].value));
    EXPECT_GT(free.share[2], 1 - 1e-9);
  }
}

// Of a phased law both yields of an axis, each where it counts.
TEST(FreeCourse, FindsTheYieldsOfBothPhases) {
  std::vector<double> gains(kPhasedGains, 1e-3);
  gains[6] = 0.02;
  std::vector<Samples> all = episodes_with(0, 0);
  for (Samples& episode : all)
    for (Sample& s : episode) {
      s.velocity = law_velocity(LawKind::phased, gains.data(), s);
      s.velocity.y() += std::sin(50 * s.depth);
    }
  std::vector<double> others = gains;
  others[4] = others[5] = others[11] = others[12] = 3;
  const FreeCourse free = free_course(LawKind::phased, others, all);
  for (const std::size_t i : {5u, 12u}) EXPECT_CLOSE(free.yields[i].value, gains[i], 1e-7);
}

TEST(FreeCourse, SaysHowMuchTheYieldsExplain) {
  const auto share = [](double noise) {
    const std::vector<double> gains(kGains, 1);
    return free_course(LawKind::insertion, gains, episodes_with(1, noise)).share;
  };
  // Forces of up to 1.5 N swing, so the velocity varies by kYieldZ 1.5/sqrt(2) beside the noise.
  const double yields = kYieldZ * 1.5 / std::sqrt(2);
  for (const double noise : {0.5 * yields, 3 * yields})
    EXPECT_NEAR(share(noise)[2], yields * yields / (yields * yields + noise * noise), 0.05);
  EXPECT_TRUE(std::isnan(share(0)[0]));
}

TEST(WithYields, TakesThoseThatAreDetermined) {
  const FreeCourse free{{{2, 1.9, 2.1}, {NAN, NAN, NAN}, {1, 0.9999, 1.0001}, {1, 0.5, 1.5}}};
  const auto gains =
      with_yields({{1, 0.9, 1.1}, {3, 2, 4}, {1.1, 1.0999, 1.1001}, {0.9, 0.8, 1}}, free);
  const std::array<FittedGain, 4> expected = {
      {{2, 1.9, 2.1}, {3, 2, 4}, {1, 1 - kLeastError, 1 + kLeastError}, {0.9, 0.5, 1.5}}};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(gains[i].value, expected[i].value);
    EXPECT_CLOSE(gains[i].low, expected[i].low, 1e-12);
    EXPECT_CLOSE(gains[i].high, expected[i].high, 1e-12);
  }
}

// What is at a bound stays there.
TEST(WithYields, LeavesWhatHasNoInterval) {
  const auto gains = with_yields({{0, NAN, NAN}}, FreeCourse{{{1, 0.99, 1.01}}});
  EXPECT_EQ(gains[0].value, 0);
  EXPECT_TRUE(std::isnan(gains[0].low));
}

// The operator's yield is in the interval, or a warning says that it may not be.
class HisYieldInSeconds : public ::testing::TestWithParam<const char*> {};
TEST_P(HisYieldInSeconds, IsInTheIntervalOrWarnedOf) {
  constexpr double kSkill = 0.8;
  const double yield = trainee_traits(kSkill).yield;
  const Scene scene = load_scene(GetParam());
  const DemonstrationSet set = simulated_demonstrations(scene, kSkill, 21, 8);
  const LawFile law = fit_law(set, 1, LawKind::insertion).controller;
  const std::vector<std::string> warnings = fit_warnings(set, law);
  for (const std::string name : {"yield_y", "yield_z"}) {
    const FittedGain& gain = law.gains[place(LawKind::insertion, name)];
    const bool warned = std::any_of(warnings.begin(), warnings.end(), [&](const std::string& w) {
      return w.starts_with(name + " is not determined");
    });
    EXPECT_TRUE(warned || (gain.low <= yield && yield <= gain.high))
        << name << " " << gain.low << " to " << gain.high;
    // He presses from 7 tenths of his way on, which no law does.
    if (!warned) {
      EXPECT_NEAR(gain.value, yield, 0.03 * yield) << name;
      EXPECT_LT(gain.high - gain.low, 0.08 * yield) << name;
    }
    EXPECT_TRUE(std::none_of(warnings.begin(), warnings.end(), [&](const std::string& w) {
      return w.starts_with(name + " is not one number");
    }));
    // Where the force says little the eye or the tremor says the rest.
    EXPECT_EQ(warned, std::string(GetParam()) == "laser" || std::string(GetParam()) == "paper");
  }
}
INSTANTIATE_TEST_SUITE_P(OfTheOperator, HisYieldInSeconds,
                         ::testing::Values("bench", "demo", "epoxy", "laser", "paper"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace ferrule
