// Eigen's vectors as those of controller/search, and back.
#pragma once

#include <Eigen/Core>

#include "controller/search/axes.h"

namespace ferrule::testing {

inline ferrule_v2 in_c(const Eigen::Vector2d& v) noexcept {
  return {v.x(), v.y()};
}
inline Eigen::Vector2d in_eigen(const ferrule_v2& v) noexcept {
  return {v.y, v.z};
}

}  // namespace ferrule::testing
