#include "learn/solve_law.hpp"

#include "tests/compare.hpp"
#include "tests/law_episodes.hpp"

namespace ferrule {
namespace {

using testing::kScales;
using testing::law_episodes;
using testing::usual_law;

TEST(SolveLaw, ReturnsTheGainsOfEachLawWithoutNoise) {
  for (const LawKind kind : kLaws) {
    const Law law = usual_law(kind);
    const LawSolution s = solve_law(kind, law_episodes(law, 4, 800, 0, 1), kScales);
    ASSERT_EQ(s.gains.size(), law.gains().size()) << s.summary;
    for (std::size_t i = 0; i < s.gains.size(); ++i)
      EXPECT_CLOSE(s.gains[i], law.gains()[i], 1e-6)
          << name(kind) << " " << gain_table(kind)[i].name;
  }
}

// More gains never fit worse, whatever made the data.
TEST(SolveLawInSeconds, ALawFitsAtLeastAsWellAsTheLawWithinIt) {
  for (const LawKind made_by : kLaws) {
    const auto data = law_episodes(usual_law(made_by), 3, 200, 3e-4, 1);
    const auto cost = [&](LawKind kind) {
      return solve_law(kind, data, kScales, Effort::rough).cost;
    };
    const double linear = cost(LawKind::linear), phased = cost(LawKind::phased);
    EXPECT_LE(phased, linear * (1 + 1e-9));
    EXPECT_LE(cost(LawKind::saturated), phased * (1 + 1e-9));
    EXPECT_LE(cost(LawKind::guarded), cost(LawKind::insertion) * (1 + 1e-9));
  }
}

// A law with more gains than the data were made with finds the values at which they do nothing.
TEST(SolveLaw, AWiderLawFindsTheNarrowerOneThatMadeTheData) {
  const Law law = usual_law(LawKind::linear);
  const auto data = law_episodes(law, 4, 800, 0, 2);
  const std::vector<double> g = solve_law(LawKind::saturated, data, kScales).gains;
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_CLOSE(g[i], law.gains()[i], 1e-5);
    EXPECT_CLOSE(g[7 + i], law.gains()[i], 1e-5);
  }
  EXPECT_LT(g[13], 1e-5);
  EXPECT_LT(g[14], 1e-5);
}

// Nominal 95 %, though the noise of one episode lasts.
TEST(SolveLawAtLength, IntervalsHoldTheTruthAboutAsOftenAsTheySay) {
  for (const LawKind kind :
       {LawKind::linear, LawKind::phased, LawKind::guarded, LawKind::saturated}) {
    const Law law = usual_law(kind);
    int inside = 0, all = 0;
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
      const auto data = law_episodes(law, 10, 350, 2e-4, seed);
      const LawSolution s = solve_law(kind, data, kScales, Effort::rough);
      const auto gains = law_gains(kind, data, kScales, s);
      for (std::size_t i = 0; i < gains.size(); ++i) {
        if (std::isnan(gains[i].low)) continue;
        inside += gains[i].low <= law.gains()[i] && law.gains()[i] <= gains[i].high;
        ++all;
      }
    }
    EXPECT_GT(all, 0.9 * 8 * static_cast<double>(law.gains().size())) << name(kind);
    EXPECT_GT(inside, 0.85 * all) << name(kind);
    EXPECT_LT(inside, all) << name(kind) << ": intervals that always hold the truth are too wide";
  }
}

// Yields and dead bands are not negative, and neither are the ends of their intervals.
TEST(SolveLaw, IntervalsStayWithinTheBoundsOfTheGains) {
  Law law = usual_law(LawKind::saturated);
  std::vector<double> gains = law.gains();
  gains[3] = 1e-6;
  gains[13] = 1e-3;
  law = Law(LawKind::saturated, gains);
  const auto data = law_episodes(law, 4, 300, 1e-3, 1);
  const auto fitted =
      law_gains(LawKind::saturated, data, kScales, solve_law(LawKind::saturated, data, kScales));
  for (const std::size_t i : {3u, 4u, 5u, 10u, 11u, 12u, 13u, 14u})
    EXPECT_TRUE(std::isnan(fitted[i].low) || fitted[i].low >= 0) << i;
}

}  // namespace
}  // namespace ferrule
