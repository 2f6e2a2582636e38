#include "controller/mated_pairs.hpp"

#include <algorithm>
#include <numbers>

#include "sim/base/random.hpp"
#include "tests/compare.hpp"

namespace ferrule {
namespace {

// Offsets normal in y and in z, without slopes; of the same length where `length` says so.
std::vector<LightAxis> scattered(std::size_t count, double size, bool length = false) {
  std::vector<LightAxis> ends(count);
  for (std::size_t k = 0; k < count; ++k) {
    RandomStream random(3, k, Draw::start);
    ends[k].offset = Vector2d(random.normal(), random.normal());
    ends[k].offset *= size / (length ? ends[k].offset.norm() : 1);
  }
  return ends;
}

// The offset of two normal ones is normal with twice the variance in y and in z, so that the loss
// is exponentially distributed: its mean is 4.343 (4 sd^2)/w^2, and 97 % are within -ln 0.03 of it.
TEST(MatedPairs, OfNormalOffsetsLoseExponentially) {
  const MatedPairs m = mate({}, scattered(4000, 0.4e-6), 7, false, 100'000);
  const double mean = 4.343 * 4 * 0.4 * 0.4 / (5.2 * 5.2);
  EXPECT_EQ(m.pairs, 100'000u);
  EXPECT_CLOSE(m.mean_dB, mean, 0.05);  // 4000 connectors, each in many pairs
  EXPECT_CLOSE(m.p97_dB, -std::log(0.03) * mean, 0.08);
}

// |a - b|^2 of vectors of length r is 2 r^2 (1 - cos), and cos is 0 on average of any directions,
// (sin(pi/4)/(pi/4))^2 = 8/pi^2 of two within 45 degrees of the key.
TEST(MatedPairs, TunedOnesLoseAFifth) {
  const auto ends = scattered(500, 0.7e-6, true);
  const double alone = joint_loss_dB({}, ends[0]);
  EXPECT_CLOSE(mate({}, ends, 7, false, 100'000).mean_dB, 2 * alone, 0.02);
  EXPECT_CLOSE(mate({}, ends, 7, true, 100'000).mean_dB,
               2 * alone * (1 - 8 / (std::numbers::pi * std::numbers::pi)), 0.02);
}

TEST(MatedPairs, TurnsOffsetAndSlopeTogether) {
  std::vector<LightAxis> ends = scattered(500, 1e-6, true);
  Joint joint;
  joint.gap = 30e-6;
  // Light that leaves away from the axis does worse over a gap than light that comes back to it.
  const auto sloped = [&](double slope) {
    for (LightAxis& end : ends) end.slope = slope * end.offset.normalized();
    return mate(joint, ends, 7, false).mean_dB;
  };
  EXPECT_GT(sloped(10e-3), 1.1 * sloped(-10e-3));
}

TEST(MatedPairs, AreThoseOfTheSeedAndOfTwoConnectors) {
  const auto ends = scattered(20, 0.5e-6);
  const MatedPairs m = mate({}, ends, 7, false);
  EXPECT_EQ(m.pairs, 10'000u);
  EXPECT_EQ(mate({}, ends, 7, false).mean_dB, m.mean_dB);
  EXPECT_EQ(mate({}, ends, 7, false).p97_dB, m.p97_dB);
  EXPECT_NE(mate({}, ends, 8, false).mean_dB, m.mean_dB);
  EXPECT_EQ(mate({}, {ends[0]}, 7, false).pairs, 0u);
  EXPECT_TRUE(std::isnan(mate({}, {}, 7, true).p97_dB));
  // Each with the other, never with itself: an ideal one and one off by 1 um.
  std::vector<LightAxis> two(2);
  two[0].offset = Vector2d(1e-6, 0);
  EXPECT_CLOSE(mate({}, two, 7, false).mean_dB, joint_loss_dB({}, two[0]), 1e-12);
}

TEST(ConnectorGrade, NeedsBothLimits) {
  EXPECT_STREQ(connector_grade({1, 0.12, 0.25}), "B");
  EXPECT_STREQ(connector_grade({1, 0.121, 0.25}), "C");
  EXPECT_STREQ(connector_grade({1, 0.12, 0.251}), "C");
  EXPECT_STREQ(connector_grade({1, 0.2, 0.51}), "D");
  EXPECT_STREQ(connector_grade({1, 0.50, 1.0}), "D");
  EXPECT_EQ(connector_grade({1, 0.51, 0.9}), nullptr);
  EXPECT_EQ(connector_grade({1, 0.1, 1.01}), nullptr);
  EXPECT_EQ(connector_grade({0, NAN, NAN}), nullptr);
}

TEST(ConnectorGrade, IsOfAllWavelengths) {
  const MatedPairs at[] = {{9, 0.20, 0.24, {0.19, 0.21}, {0.22, 0.27}},
                           {9, 0.10, 0.45, {0.09, 0.11}, {0.40, 0.51}}};
  const MatedPairs worst = worst_of({at[0], at[1]});
  EXPECT_EQ(worst.mean_dB, 0.20);
  EXPECT_EQ(worst.p97_dB, 0.45);
  EXPECT_EQ(worst.mean_95.high, 0.21);
  EXPECT_EQ(worst.p97_95.low, 0.40);
  EXPECT_STREQ(connector_grade(worst), "C");
  EXPECT_EQ(allowed_grades(worst).size(), 2u);  // C and D
}

// Between the grade of both low ends and that of both high ends.
TEST(ConnectorGrade, IsAsUncertainAsItsIntervals) {
  constexpr double kOpen = std::numeric_limits<double>::infinity();
  const auto allowed = [](Interval mean, Interval p97) {
    std::string text;
    for (const char* grade : allowed_grades({9, mean.low, p97.low, mean, p97}))
      text += grade ? grade : "-";
    return text;
  };
  EXPECT_EQ(allowed({0.10, 0.11}, {0.20, 0.24}), "B");
  EXPECT_EQ(allowed({0.10, 0.13}, {0.20, 0.24}), "BC");
  EXPECT_EQ(allowed({0.10, 0.11}, {0.24, 0.60}), "BCD");
  EXPECT_EQ(allowed({0.20, 0.22}, {0.45, kOpen}), "CD-");
  EXPECT_EQ(allowed({0.60, 0.70}, {1.50, 1.70}), "-");
  EXPECT_EQ(allowed({NAN, NAN}, {NAN, NAN}), "BCD-");
  EXPECT_TRUE(allowed_grades({0, NAN, NAN}).empty());
}

// Of the lots, that many intervals have the truth of what they were drawn from: the exponential.
TEST(MatedPairs, IntervalsHaveTheTruth) {
  constexpr int kLots = 200;
  const double mean = 4.343 * 4 * 0.4 * 0.4 / (5.2 * 5.2), p97 = -std::log(0.03) * mean;
  for (const auto& [count, least] : {std::pair(60, 0.86), std::pair(400, 0.90)}) {
    int has_mean = 0, has_p97 = 0;
    double width = 0;
    for (int lot = 0; lot < kLots; ++lot) {
      std::vector<LightAxis> ends(static_cast<std::size_t>(count));
      for (std::size_t k = 0; k < ends.size(); ++k) {
        RandomStream random(1000 + static_cast<std::uint64_t>(lot), k, Draw::start);
        ends[k].offset = 0.4e-6 * Vector2d(random.normal(), random.normal());
      }
      const MatedPairs m = mate({}, ends, 7, false, 4000);
      has_mean += m.mean_95.low <= mean && mean <= m.mean_95.high;
      has_p97 += m.p97_95.low <= p97 && p97 <= m.p97_95.high;
      width += (m.mean_95.high - m.mean_95.low) / mean / kLots;
    }
    EXPECT_GE(has_mean, least * kLots) << count;
    EXPECT_GE(has_p97, least * kLots) << count;
    EXPECT_LT(has_mean, kLots) << count;  // nor is it wider than it says
    // The mean of a connector's own losses varies by half as much as they do: 4 (1/2)^2/n.
    EXPECT_CLOSE(width, 2 * 1.96 * std::sqrt(1.0 / count + 1.0 / 4000), 0.25) << count;
  }
}

TEST(MatedPairs, OfFewConnectorsTellLittle) {
  const MatedPairs few = mate({}, scattered(kFewestGraded - 1, 0.4e-6), 7, false);
  EXPECT_GT(few.mean_dB, 0);
  EXPECT_TRUE(std::isnan(few.mean_95.low) && std::isnan(few.p97_95.high));
  const MatedPairs more = mate({}, scattered(kFewestGraded, 0.4e-6), 7, false);
  EXPECT_LT(more.mean_95.low, more.mean_dB);
  EXPECT_GT(more.mean_95.high, more.mean_dB);
  EXPECT_TRUE(std::isinf(more.p97_95.high));
}

}  // namespace
}  // namespace ferrule
