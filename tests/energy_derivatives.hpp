// Gradient and Hessian of a step's potential against central differences, for tests.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "sim/terms/potential.hpp"

namespace ferrule::testing {

// At `tip`, for a fibre that is in by `length` [m]; `steps` of the pose [m, rad].
inline void expect_energy_derivatives(const World& world, const FrozenCoefficients& frozen,
                                      const Pose& tip, double length,
                                      const std::array<double, 5>& steps) {
  const Potential here(world, frozen, tip);
  const Pose gradient = here.gradient.full();
  const Matrix5 hessian = here.hessian.full();
  const double stiffest = hessian.topLeftCorner<3, 3>().norm();
  const auto lever = [&](int i) { return i < 3 ? 1.0 : length; };
  for (int i = 0; i < 5; ++i) {
    const double by = steps[static_cast<std::size_t>(i)];
    Pose step = Pose::Zero();
    step[i] = by;
    const Potential up(world, frozen, Pose(tip + step)), down(world, frozen, Pose(tip - step));
    EXPECT_LE(std::abs((up.value - down.value) / (2 * by) - gradient[i]),
              1e-3 * lever(i) * here.force_scale)
        << i;
    const Pose column = (up.gradient.full() - down.gradient.full()) / (2 * by);
    for (int j = 0; j < 5; ++j)
      EXPECT_LE(std::abs(column[j] - hessian(j, i)), 5e-3 * lever(i) * lever(j) * stiffest)
          << i << " " << j;
  }
}

}  // namespace ferrule::testing
