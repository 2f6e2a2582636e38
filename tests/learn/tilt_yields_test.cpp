#include "learn/tilt_yields.hpp"

#include "tests/compare.hpp"
#include "tests/law_episodes.hpp"

namespace ferrule {
namespace {

constexpr double kTilting[] = {4e-3, 1.5e-3};  // [rad/(s N m)]

// Hands that tilt under moments that swing, by kTilting, and besides as a hand trembles: `tremor`
// [rad/s] that lasts a third of a second.
std::vector<Samples> hands(double tremor, std::uint64_t seed) {
  std::vector<Samples> all =
      testing::law_episodes(testing::usual_law(LawKind::linear), 8, 800, 0, seed);
  for (std::size_t e = 0; e < all.size(); ++e) {
    RandomStream random(seed, 100 + e, Draw::operator_hand);
    const double phase = 6 * random.uniform();
    Eigen::Vector2d wander = Eigen::Vector2d::Zero();
    for (Sample& s : all[e])
      for (int i = 0; i < 2; ++i) {
        wander[i] += -wander[i] * 0.01 / 0.3 + tremor * std::sqrt(0.02 / 0.3) * random.normal();
        s.wrench[3 + i] = 0.7 * std::sin((1.3 + i) * s.time + phase);
        s.tilt_rate[i] = kTilting[i] * s.wrench[3 + i] + wander[i];
      }
  }
  return all;
}

TEST(TiltYields, AreThoseOfTheHands) {
  const TiltYields yields = tilt_yields(hands(0, 1));
  EXPECT_CLOSE(yields.share, 1, 1e-12);
  ASSERT_EQ(yields.gains.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) EXPECT_CLOSE(yields.gains[i].value, kTilting[i], 1e-12);
}

TEST(TiltYields, IntervalsHoldTheTruth) {
  int inside = 0, all = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const TiltYields yields = tilt_yields(hands(1e-3, seed));
    for (std::size_t i = 0; i < 2; ++i, ++all)
      inside += yields.gains[i].low <= kTilting[i] && kTilting[i] <= yields.gains[i].high;
  }
  EXPECT_GT(inside, 0.9 * all);
  EXPECT_LT(inside, all) << "intervals that always hold the truth are too wide";
}

TEST(TiltYields, HandsThatNeverTiltOrForOtherReasonsHaveNone) {
  std::vector<Samples> still = hands(0, 1);
  for (Samples& episode : still)
    for (Sample& s : episode) s.tilt_rate.setZero();
  EXPECT_TRUE(std::isnan(tilt_yields(still).share));
  EXPECT_TRUE(tilt_yields(still).gains.empty());
  const TiltYields trembling = tilt_yields(hands(0.1, 1));
  EXPECT_LT(trembling.share, kLeastToldByMoments);
  EXPECT_TRUE(trembling.gains.empty());
}

// One who tilts against the moment is not passive; his yield is at its bound.
TEST(TiltYields, AreNotNegative) {
  std::vector<Samples> episodes = hands(0, 1);
  for (Samples& episode : episodes)
    for (Sample& s : episode) s.tilt_rate[1] *= -1;
  const TiltYields yields = tilt_yields(episodes);
  ASSERT_EQ(yields.gains.size(), 2u);
  EXPECT_GT(yields.gains[0].low, 0);
  EXPECT_EQ(yields.gains[1].value, 0);
  EXPECT_TRUE(std::isnan(yields.gains[1].low));
}

}  // namespace
}  // namespace ferrule
