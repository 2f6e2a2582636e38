#include "learn/fit_law.hpp"

#include "learn/record_again.hpp"
#include "tests/compare.hpp"
#include "tests/demonstrations.hpp"
#include "tests/episodes.hpp"
#include "tests/scenes.hpp"
#include "tests/temporary_folder.hpp"

namespace ferrule {
namespace {

// Demonstrations of an insertion law.
DemonstrationSet synthetic(const std::array<double, kGains>& gains, int episodes, double noise,
                           std::uint64_t seed = 1, int delay = 0) {
  return testing::demonstrations(
      [&](const Eigen::Vector3d& force, double depth, double time) {
        return insertion_velocity(gains.data(), kGains, testing::felt(force, depth, time));
      },
      6e-3, episodes, delay, noise, seed);
}

constexpr std::array<double, kGains> kLaw = {4.2e-3,  0.9,    0.017,  0.006, 0.12,  2e-4,
                                             0.85e-3, 0.7e-3, 1.5e-5, -2e-5, -3e-3, 2e-3};

TEST(FitLaw, ReturnsTheGainsOfAKnownLawWithoutNoise) {
  const LawFit report = fit_law(synthetic(kLaw, 6, 0), 1);
  EXPECT_EQ(report.controller.reaction_time, 0);
  for (std::size_t i = 0; i < kGains; ++i)
    EXPECT_CLOSE(report.controller.gains[i].value, kLaw[i], 1e-6) << kGainTable[i].name;
}

TEST(FitLaw, ReturnsTheGainsOfALinearAdmittance) {
  std::array<double, kGains> linear = {3e-3, 0.4,    0.03, 0.003, 0,    5e-4,
                                       1e-3, 1.2e-3, 1e-5, 2e-5,  1e-3, 2e-3};
  const LawFit report = fit_law(synthetic(linear, 6, 0), 1);
  for (const std::size_t i : {0u, 5u, 6u, 7u, 8u, 9u, 10u, 11u})
    EXPECT_CLOSE(report.controller.gains[i].value, linear[i], 1e-6) << kGainTable[i].name;
}

TEST(FitLaw, ChoosesTheLawWhereItIsNotGiven) {
  const DemonstrationSet set = synthetic(kLaw, 4, 1e-4);
  const LawFile chosen = fit_law(set, 1, std::nullopt).controller;
  EXPECT_EQ(chosen.kind, LawKind::insertion);
  EXPECT_EQ(chosen.cross_validation.size(), kLaws.size());
  // It is the law that is fitted where it is given.
  const LawFile given = fit_law(set, 1).controller;
  EXPECT_EQ(given.law().gains(), chosen.law().gains());
  EXPECT_TRUE(given.cross_validation.empty());
}

TEST(FitLaw, IdentifiesTheReactionTime) {
  EXPECT_CLOSE(fit_law(synthetic(kLaw, 5, 0, 1, 180), 1).controller.reaction_time, 0.18, 1e-9);
}

// Intervals of nominal 95 % must hold the truth about that often, though the noise of one episode
// is correlated over a third of a second.
TEST(FitLawAtLength, IntervalsHoldTheTruth) {
  int inside = 0, all = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const LawFit report = fit_law(synthetic(kLaw, 12, 2e-4, seed), 1);
    for (const std::size_t i : {0u, 1u, 2u, 3u, 4u, 5u, 6u, 7u}) {
      const FittedGain& g = report.controller.gains[i];
      inside += g.low <= kLaw[i] && kLaw[i] <= g.high;
      ++all;
    }
  }
  EXPECT_GT(inside, 0.85 * all);
  EXPECT_LT(inside, all) << "intervals that always hold the truth are too wide";
}

// The whole way: a known controller inserts, is recorded, and is fitted from the files.
TEST(FitLawAtLength, ReturnsTheGainsOfARecordedController) {
  const testing::TemporaryFolder folder;
  const Scene scene =
      testing::paper({"start.lateral_sd_um=3", "start.distance_um=40", "success.depth_um=30"});
  const std::array<double, kGains> gains = {1.7e-3, 0.8,  0.012, 0.004, 0.2,   1e-4,
                                            0.9e-3, 1e-3, 1e-5,  -1e-5, -2e-3, 1e-3};
  std::vector<double> all(gains.begin(), gains.end());
  all.insert(all.end(), {4e-4, 2e-4});
  Law law(LawKind::insertion, all);
  for (std::uint64_t trial = 1; trial <= 6; ++trial)
    testing::record(scene, folder.path(), trial, &law);
  const DemonstrationSet set = load_demonstrations(folder.path());
  ASSERT_GE(set.demonstrations.size(), 5u);
  const LawFit report = fit_law(set, 1);
  ASSERT_EQ(report.controller.gains.size(), all.size());
  for (std::size_t i = 0; i < all.size(); ++i)
    EXPECT_CLOSE(report.controller.gains[i].value, all[i], 1e-6)
        << gain_of(LawKind::insertion, i).name;
}

// A hand that tilts under moments, with a delay, tremor and hesitations.
TEST(FitLawAtLength, ReturnsHowASimulatedOperatorTilts) {
  const Scene scene = load_scene("bench");
  const LawFile law =
      fit_law(simulated_demonstrations(scene, OperatorSkill::parse("0.8,tilt_yield=2e-4"), 1, 5), 1)
          .controller;
  ASSERT_TRUE(law.law().tilts());
  for (const std::size_t i : {0u, 1u}) EXPECT_CLOSE(law.gains[kGains + i].value, 2e-4, 1e-6);
  EXPECT_FALSE(fit_law(simulated_demonstrations(scene, 0.8, 1, 5), 1).controller.law().tilts());
}

TEST(FitLaw, RefusesTooLittleWithTheReason) {
  try {
    fit_law(synthetic(kLaw, 2, 0), 1);
    FAIL();
  } catch (const BadInput& error) {
    EXPECT_NE(std::string(error.what()).find("too few demonstrations: 2"), std::string::npos);
  }
  DemonstrationSet quiet = synthetic(kLaw, 4, 0);
  for (auto& d : quiet.demonstrations)
    for (Observation& o : d.observations) o.wrench.setZero();
  try {
    fit_law(quiet, 1);
    FAIL();
  } catch (const BadInput& error) {
    EXPECT_NE(std::string(error.what()).find("tell nothing about the answer to force"),
              std::string::npos);
  }
}

TEST(FitLaw, HoldsOutWholeEpisodes) {
  const LawFit report = fit_law(synthetic(kLaw, 10, 1e-4), 3);
  EXPECT_EQ(report.controller.trained_on.held_out.size(), 2u);
  EXPECT_EQ(report.controller.trained_on.episodes.size(), 8u);
  for (const auto& file : report.controller.trained_on.held_out)
    EXPECT_EQ(std::count(report.controller.trained_on.episodes.begin(),
                         report.controller.trained_on.episodes.end(), file),
              0);
}

}  // namespace
}  // namespace ferrule
