#include "controller/sensitivity.hpp"

#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "sim/base/random.hpp"
#include "tests/compare.hpp"

namespace ferrule {
namespace {

using Three = std::array<double, 3>;

constexpr std::size_t kNone = 3, kAll = 4;

Three drawn(std::uint64_t trial, std::size_t again) {
  Three x;
  for (std::size_t i = 0; i < 3; ++i)
    x[i] = RandomStream(i == again || again == kAll ? 6 : 5, trial,
                        std::string(1, static_cast<char>('a' + i)))
               .uniform();
  return x;
}

using Result = std::function<double(const Three&)>;

std::vector<double> results(const Result& f, std::size_t again, std::size_t trials,
                            std::uint64_t first) {
  std::vector<double> all;
  for (std::uint64_t k = first; k < first + trials; ++k) all.push_back(f(drawn(k, again)));
  return all;
}

SobolIndex index_of(std::size_t key, std::size_t trials, const Result& f, std::uint64_t first = 0) {
  return total_index(results(f, kNone, trials, first), results(f, key, trials, first), 1);
}

SobolIndex first_order_of(std::size_t key, std::size_t trials, const Result& f,
                          std::uint64_t first = 0) {
  return first_order_index(results(f, kNone, trials, first), results(f, key, trials, first),
                           results(f, kAll, trials, first), 1);
}

// Ishigami and Homma 1990: sin x1 + 7 sin^2 x2 + 0.1 x3^4 sin x1, x uniform in (-pi, pi).
double ishigami(const Three& u) {
  const auto x = [&](std::size_t i) { return std::numbers::pi * (2 * u[i] - 1); };
  return std::sin(x(0)) * (1 + 0.1 * std::pow(x(2), 4)) + 7 * std::pow(std::sin(x(1)), 2);
}

TEST(Sensitivity, OfIshigamisFunctionIsItsClosedForm) {
  // V1 = (1 + b pi^4/5)^2/2, V2 = a^2/8, V13 = 8 b^2 pi^8/225.
  const double p4 = std::pow(std::numbers::pi, 4);
  const double v1 = 0.5 * std::pow(1 + 0.1 * p4 / 5, 2), v2 = 49.0 / 8,
               v13 = 8 * 0.01 * p4 * p4 / 225, v = v1 + v2 + v13;
  const Three exact = {(v1 + v13) / v, v2 / v, v13 / v};
  for (std::size_t i = 0; i < 3; ++i) {
    const SobolIndex t = index_of(i, 20000, ishigami);
    EXPECT_CLOSE(t.index, exact[i], 0.03) << i;
    EXPECT_CLOSE(t.interval.low, t.index, 0.05) << i;
    EXPECT_CLOSE(t.interval.high, t.index, 0.05) << i;
  }
  const Three alone = {v1 / v, v2 / v, 0};
  for (std::size_t i = 0; i < 3; ++i) {
    const SobolIndex s = first_order_of(i, 20000, ishigami);
    EXPECT_NEAR(s.index, alone[i], 0.02) << i;
    EXPECT_LE(s.interval.low, s.index) << i;
    EXPECT_GE(s.interval.high, s.index) << i;
    EXPECT_LT(s.interval.high - s.interval.low, 0.08) << i;
  }
}

// P(x1 < 0.3 and x2 < 0.5) = 0.15: E[Var | x2] = 0.5 0.3 0.7, E[Var | x1] = 0.3 0.5 0.5.
double both(const Three& u) {
  return u[0] < 0.3 && u[1] < 0.5 ? 1 : 0;
}

// Of `both`: how many of 200 intervals, of x1 and x2 in turn, have their index, which are these
// variances of that of all.
int covered_of_200(SobolIndex (*index)(std::size_t, std::size_t, const Result&, std::uint64_t),
                   double of_x1, double of_x2) {
  const double v = 0.15 * 0.85;
  int covered = 0;
  for (std::uint64_t k = 0; k < 200; ++k) {
    const Interval interval = index(k % 2, 200, both, 1000 * k).interval;
    const double exact = (k % 2 == 0 ? of_x1 : of_x2) / v;
    covered += interval.low <= exact && exact <= interval.high;
  }
  return covered;
}

// 95 % of 200 are 190.
TEST(Sensitivity, IntervalsOfASuccessRateCoverTheIndex) {
  EXPECT_GE(covered_of_200(index_of, 0.5 * 0.21, 0.3 * 0.25), 180);
}

TEST(Sensitivity, WhatDoesNotMatterHasNone) {
  for (const SobolIndex& i : {index_of(2, 200, both), first_order_of(2, 200, both)}) {
    EXPECT_EQ(i.index, 0);
    EXPECT_EQ(i.interval.low, 0);
    EXPECT_GT(i.interval.high, 0);
    EXPECT_LT(i.interval.high, 0.1);
  }
}

// 4 x1 + 2 x2 + x3 - a constant that is large beside them: 16, 4 and 1 of 21 parts.
TEST(Sensitivity, OfASumFirstOrderAndTotalAreTheSameShares) {
  const auto sum = [](const Three& u) { return 4 * u[0] + 2 * u[1] + u[2] - 100; };
  const Three exact = {16.0 / 21, 4.0 / 21, 1.0 / 21};
  double all = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(first_order_of(i, 20000, sum).index, exact[i], 0.02) << i;
    EXPECT_CLOSE(index_of(i, 20000, sum).index, exact[i], 0.03) << i;
    all += first_order_of(i, 20000, sum).index;
  }
  EXPECT_NEAR(all, 1, 0.04);
}

// Of the sign of a product either alone says nothing, and both together all.
TEST(Sensitivity, OfAPureInteractionTheFirstOrderIsNoneAndEachTotalIsAll) {
  const auto sign = [](const Three& u) { return (u[0] > 0.5) == (u[1] > 0.5) ? 1.0 : 0.0; };
  for (std::size_t i = 0; i < 2; ++i) {
    const SobolIndex alone = first_order_of(i, 5000, sign);
    EXPECT_NEAR(alone.index, 0, 0.05) << i;
    EXPECT_LT(alone.interval.low, 0) << i;
    EXPECT_GT(alone.interval.high, 0) << i;
    EXPECT_CLOSE(index_of(i, 5000, sign).index, 1, 0.05) << i;
  }
}

// P(x1 < 0.3 and x2 < 0.5): Var(E | x1) = 0.25 0.21, Var(E | x2) = 0.09 0.25.
TEST(Sensitivity, IntervalsOfASuccessRateCoverTheFirstOrder) {
  EXPECT_GE(covered_of_200(first_order_of, 0.25 * 0.21, 0.09 * 0.25), 180);
}

TEST(Sensitivity, NeedsResultsThatDiffer) {
  const auto same = [](const Three&) { return 1.0; };
  EXPECT_TRUE(std::isnan(index_of(0, 100, same).index));
  EXPECT_TRUE(std::isnan(first_order_of(0, 100, same).index));
  EXPECT_TRUE(std::isnan(total_index({}, {}, 1).index));
  EXPECT_TRUE(std::isnan(total_index({1, NAN}, {2, 3}, 1).index));
  EXPECT_TRUE(std::isnan(first_order_index({1, 2}, {2, 3}, {NAN, 4}, 1).index));
  EXPECT_EQ(total_index({1, 2, NAN, 5}, {1, 2, 3, NAN}, 1).index, 0);
  EXPECT_THROW(total_index({1}, {}, 1), std::invalid_argument);
  EXPECT_THROW(first_order_index({1}, {1}, {}, 1), std::invalid_argument);
}

}  // namespace
}  // namespace ferrule
