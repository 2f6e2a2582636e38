// Relative comparison, and derivatives by central differences, for tests.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace ferrule::testing {

// |a - b| <= tolerance * |b|: for quantities of any size, where an absolute tolerance would pass 0.
inline ::testing::AssertionResult close(double a, double b, double tolerance) {
  if (std::abs(a - b) <= tolerance * std::abs(b)) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure()
         << a << " is not " << b << " within " << tolerance << " of it";
}

// df/dx by Richardson's extrapolation of central differences with steps `h` and h/2.
inline double derivative(const std::function<double(double)>& f, double x, double h) {
  const auto central = [&](double d) { return (f(x + d) - f(x - d)) / (2 * d); };
  return (4 * central(h / 2) - central(h)) / 3;
}

// A law's force and slope at x are what its potential says: force = -+ dU/dx (`sign` -1 where x is
// a gap, +1 where it is a depth), slope = d force/dx.
template <typename Law>
void expect_derivatives(const Law& at, double x, double step, double tolerance, double sign = -1) {
  const double force = sign * derivative([&](double y) { return at(y).potential; }, x, step);
  const double slope = derivative([&](double y) { return at(y).force; }, x, step);
  EXPECT_TRUE(close(at(x).force, force, tolerance)) << "force at " << x;
  EXPECT_TRUE(close(at(x).slope, slope, tolerance)) << "slope at " << x;
}

}  // namespace ferrule::testing

#define EXPECT_CLOSE(a, b, tolerance) EXPECT_TRUE(::ferrule::testing::close(a, b, tolerance))
