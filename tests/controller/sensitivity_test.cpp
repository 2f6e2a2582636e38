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

Three drawn(std::uint64_t trial, std::size_t again) {
  Three x;
  for (std::size_t i = 0; i < 3; ++i)
    x[i] = RandomStream(i == again ? 6 : 5, trial, std::string(1, static_cast<char>('a' + i)))
               .uniform();
  return x;
}

TotalIndex index_of(std::size_t key, std::size_t trials,
                    const std::function<double(const Three&)>& f, std::uint64_t first = 0) {
  std::vector<double> once, again;
  for (std::uint64_t k = first; k < first + trials; ++k) {
    once.push_back(f(drawn(k, 3)));
    again.push_back(f(drawn(k, key)));
  }
  return total_index(once, again, 1);
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
    const TotalIndex t = index_of(i, 20000, ishigami);
    EXPECT_CLOSE(t.total, exact[i], 0.03) << i;
    EXPECT_CLOSE(t.interval.low, t.total, 0.05) << i;
    EXPECT_CLOSE(t.interval.high, t.total, 0.05) << i;
  }
}

// P(x1 < 0.3 and x2 < 0.5) = 0.15: E[Var | x2] = 0.5 0.3 0.7, E[Var | x1] = 0.3 0.5 0.5.
double both(const Three& u) {
  return u[0] < 0.3 && u[1] < 0.5 ? 1 : 0;
}

TEST(Sensitivity, IntervalsOfASuccessRateCoverTheIndex) {
  const double v = 0.15 * 0.85;
  int covered = 0;
  for (std::uint64_t k = 0; k < 200; ++k) {
    const TotalIndex t = index_of(k % 2, 200, both, 1000 * k);
    const double exact = (k % 2 == 0 ? 0.5 * 0.21 : 0.3 * 0.25) / v;
    covered += t.interval.low <= exact && exact <= t.interval.high;
  }
  EXPECT_GE(covered, 180);  // of 95 % of 200
}

TEST(Sensitivity, WhatDoesNotMatterHasNone) {
  const TotalIndex t = index_of(2, 200, both);
  EXPECT_EQ(t.total, 0);
  EXPECT_EQ(t.interval.low, 0);
  EXPECT_GT(t.interval.high, 0);
  EXPECT_LT(t.interval.high, 0.1);
}

TEST(Sensitivity, NeedsResultsThatDiffer) {
  EXPECT_TRUE(std::isnan(index_of(0, 100, [](const Three&) { return 1.0; }).total));
  EXPECT_TRUE(std::isnan(total_index({}, {}, 1).total));
  EXPECT_TRUE(std::isnan(total_index({1, NAN}, {2, 3}, 1).total));
  EXPECT_EQ(total_index({1, 2, NAN, 5}, {1, 2, 3, NAN}, 1).total, 0);
  EXPECT_THROW(total_index({1}, {}, 1), std::invalid_argument);
}

}  // namespace
}  // namespace ferrule
