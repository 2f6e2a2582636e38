#include "sim/solver/find_root.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/compare.hpp"

namespace ferrule {
namespace {

TEST(Bisect, HalvesTheBracketOfARoot) {
  int calls = 0;
  const auto below = [&](double x) {
    ++calls;
    return x * x < 2;
  };
  for (const int times : {0, 1, 10, 40}) {
    calls = 0;
    const auto end = bisect(Bracket<double>{0, 2}, times, below, midpoint);
    EXPECT_EQ(calls, times);
    EXPECT_DOUBLE_EQ(end.fails - end.holds, std::ldexp(2, -times));
    EXPECT_LT(end.holds, std::sqrt(2));
    EXPECT_GE(end.fails, std::sqrt(2));
  }
}

TEST(Bisect, TakesBracketsInEitherDirection) {
  const auto above = [](double x) { return x > 0.3; };
  const auto end = bisect(Bracket<double>{1, 0}, 30, above, midpoint);
  EXPECT_GT(end.holds, 0.3);
  EXPECT_CLOSE(end.fails, 0.3, 3e-9);
}

// Geometric means reach a place that is many decades below the bracket.
TEST(Bisect, TakesTheMiddleItIsGiven) {
  const auto below = [](double x) { return x < 1e-9; };
  const auto geometric = [](double a, double b) { return std::sqrt(a * b); };
  const auto end = bisect(Bracket<double>{1e-16, 1}, 20, below, geometric);
  EXPECT_CLOSE(end.holds, 1e-9, 1e-4);
}

}  // namespace
}  // namespace ferrule
