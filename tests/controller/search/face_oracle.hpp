// Where a flat end rests on a face with a round opening, by trying points: the reference for
// controller/search/locate_opening.h and touch_search.h.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "controller/search/locate_opening.h"

namespace ferrule::testing {

// How far the lowest of the supported points is ahead of the disc's centre [m]: of points of the
// disc's rim outside the opening, and of the opening's edge under the disc. -infinity where there
// is none.
inline double rest_height_by_trial(const ferrule_discs& discs, const Eigen::Vector2d& slope,
                                   const Eigen::Vector2d& e) {
  constexpr int kPoints = 40000;
  double highest = -std::numeric_limits<double>::infinity();
  for (int k = 0; k < kPoints; ++k) {
    const double angle = 2 * std::numbers::pi * k / kPoints;
    const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
    const Eigen::Vector2d rim = discs.fibre * direction, edge = discs.opening * direction - e;
    if ((rim + e).norm() >= discs.opening) highest = std::max(highest, rim.dot(slope));
    if (edge.norm() <= discs.fibre) highest = std::max(highest, edge.dot(slope));
  }
  return highest;
}

// Two standard normal numbers, in an order that no compiler changes.
inline Eigen::Vector2d drawn(std::mt19937& random) {
  std::normal_distribution<double> normal;
  Eigen::Vector2d v;
  for (double& each : v) each = normal(random);
  return v;
}

}  // namespace ferrule::testing
