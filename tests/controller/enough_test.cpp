#include "controller/enough.hpp"

#include <array>
#include <boost/math/distributions/binomial.hpp>
#include <cmath>

#include "controller/statistics.hpp"
#include "sim/base/random.hpp"
#include "tests/compare.hpp"

namespace ferrule {
namespace {

TrialResult ended(Outcome outcome) {
  TrialResult result{};
  result.outcome = outcome;
  return result;
}

// The mean of L(p)/L(rate) over p between two rates, by the midpoint rule.
double mean_likelihood(double rate, double from, double to, int s, int f) {
  constexpr int kPoints = 200'000;
  double sum = 0;
  for (int i = 0; i < kPoints; ++i) {
    const double p = from + (to - from) * (i + 0.5) / kPoints;
    sum += std::exp(s * std::log(p / rate) + f * std::log((1 - p) / (1 - rate)));
  }
  return sum / kPoints;
}

TEST(Evidence, IsTheMeanLikelihoodOverTheRatesOnEitherSide) {
  for (const auto& [rate, s, f] :
       {std::tuple(0.9, 95, 5), {0.9, 5, 3}, {0.99, 700, 1}, {0.3, 2, 9}}) {
    const auto n = static_cast<std::size_t>(s + f);
    EXPECT_CLOSE(evidence_above(rate, static_cast<std::size_t>(s), n),
                 mean_likelihood(rate, rate, 1, s, f), 1e-6);
    EXPECT_CLOSE(evidence_below(rate, static_cast<std::size_t>(s), n),
                 mean_likelihood(rate, 0, rate, s, f), 1e-6);
  }
  EXPECT_EQ(evidence_above(0.97, 450, 900), 0);
  EXPECT_EQ(evidence_below(0.97, 450, 900), INFINITY);
  EXPECT_CLOSE(evidence_above(0.99, 0, 0), 1, 1e-12);
  EXPECT_CLOSE(evidence_below(0.99, 0, 0), 1, 1e-12);
}

// At the rate itself the next trial leaves it as it is on average; under a lower rate it does not
// grow, and that below does not under a higher one.
TEST(Evidence, DoesNotGrowOnAverageWhereItMustNot) {
  for (const std::size_t n : {std::size_t{1}, std::size_t{40}, std::size_t{900}})
    for (const std::size_t s : {n - n / 8, n - n / 40, n}) {
      const auto next = [&](auto evidence, double p) {
        return p * evidence(0.97, s + 1, n + 1) + (1 - p) * evidence(0.97, s, n + 1);
      };
      const double above = evidence_above(0.97, s, n), below = evidence_below(0.97, s, n);
      EXPECT_CLOSE(next(evidence_above, 0.97), above, 1e-9);
      EXPECT_CLOSE(next(evidence_below, 0.97), below, 1e-9);
      EXPECT_LT(next(evidence_above, 0.9), above);
      EXPECT_LT(next(evidence_below, 0.99), below);
    }
}

Verdict run(double target, double rate, std::uint64_t stream, std::size_t most) {
  RandomStream random(5, stream, Draw::start);
  Target t(target);
  while (t.verdict().kind == Verdict::undecided && t.verdict().trials < most)
    t.after(ended(random.uniform() < rate ? Outcome::inserted : Outcome::jam));
  return t.verdict();
}

using Counts = std::array<int, 3>;  // by Verdict::Kind

Counts counts(double target, double rate, std::size_t most, int streams) {
  Counts c{};
  for (int i = 0; i < streams; ++i)
    ++c[run(target, rate, static_cast<std::uint64_t>(i), most).kind];
  return c;
}

// Of what has a chance of at most 5 % so many happen no more than one time in a million. The rate
// nearest to the target that must not be shown, and that must not be refuted, is the target itself.
void expect_errors(double target, std::size_t trials, int streams) {
  const double most = quantile(complement(boost::math::binomial(streams, 0.05), 1e-6));
  const Counts at = counts(target, target, trials, streams);
  EXPECT_LE(at[Verdict::shown], most) << target;
  EXPECT_LE(at[Verdict::refuted], most) << target;
  EXPECT_GT(at[Verdict::shown] + at[Verdict::refuted], 0) << target;
  EXPECT_LE(counts(target, target - 0.02, trials, streams)[Verdict::shown], most);
  EXPECT_LE(counts(target, target + 0.5 * (1 - target), trials, streams)[Verdict::refuted], most);
}

TEST(Target, IsWronglyShownOrRefutedInAtMost5PercentOfStreams) {
  expect_errors(0.9, 400, 300);
}

TEST(TargetAtLength, IsWronglyShownOrRefutedInAtMost5PercentOfStreams) {
  for (const auto& [target, trials] : {std::pair(0.5, 300), {0.9, 1000}, {0.99, 1500}})
    expect_errors(target, static_cast<std::size_t>(trials), 2000);
}

TEST(Target, IsDecidedWhereTheRateIsFarFromIt) {
  constexpr int kStreams = 200;
  EXPECT_GE(counts(0.9, 0.98, 1000, kStreams)[Verdict::shown], 0.99 * kStreams);
  EXPECT_GE(counts(0.9, 0.7, 1000, kStreams)[Verdict::refuted], 0.99 * kStreams);
}

// Without a failure after n trials: (1 - R^(n+1))/((n + 1)(1 - R) R^n) >= 20, by hand.
TEST(Target, IsShownWithoutFailuresAfterAsManyTrialsAsTheClosedFormSays) {
  for (const double rate : {0.9, 0.99, 0.999}) {
    Target t(rate);
    while (t.verdict().kind == Verdict::undecided) t.after(ended(Outcome::inserted));
    EXPECT_EQ(t.verdict().kind, Verdict::shown);
    const auto evidence = [&](double n) {
      return (1 - std::pow(rate, n + 1)) / ((n + 1) * (1 - rate) * std::pow(rate, n));
    };
    const auto n = static_cast<double>(t.verdict().trials);
    EXPECT_GE(evidence(n), 20);
    EXPECT_LT(evidence(n - 1), 20);
  }
}

TEST(Target, KeepsItsVerdictAndLeavesOutInfeasibleTrials) {
  std::vector<TrialResult> trials(60, ended(Outcome::inserted));
  const Verdict plain = decide(0.9, trials);
  EXPECT_EQ(plain.kind, Verdict::shown);
  EXPECT_LT(plain.trials, 60u);
  trials.insert(trials.end(), 40, ended(Outcome::jam));
  EXPECT_EQ(decide(0.9, trials).kind, Verdict::shown);
  EXPECT_EQ(decide(0.9, trials).trials, plain.trials);
  trials.insert(trials.begin(), 7, ended(Outcome::infeasible));
  EXPECT_EQ(decide(0.9, trials).trials, plain.trials + 7);
  EXPECT_EQ(decide(0.9, {}).kind, Verdict::undecided);
}

TEST(Enough, IsANarrowIntervalAndADecidedTarget) {
  EXPECT_FALSE(when({}));
  const auto trials_until = [](const Enough& enough) {
    const auto known = when(enough);
    std::size_t n = 1;
    for (; !known(ended(n % 10 ? Outcome::inserted : Outcome::jam)); ++n) {
    }
    return n;
  };
  const auto width = [](std::size_t n) {
    const Interval i = wilson(n - n / 10, n);
    return i.high - i.low;
  };
  const std::size_t narrow = trials_until({.width = 0.1, .target = {}});
  EXPECT_LT(width(narrow), 0.1);
  EXPECT_GE(width(narrow - 1), 0.1);
  const std::size_t decided = trials_until({.width = {}, .target = 0.7});
  EXPECT_LT(decided, narrow);
  EXPECT_EQ(trials_until({.width = 0.1, .target = 0.7}), narrow);
  EXPECT_EQ(trials_until({.width = 0.9, .target = 0.7}), decided);
}

}  // namespace
}  // namespace ferrule
