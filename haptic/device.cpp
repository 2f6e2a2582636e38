#include "haptic/device.hpp"

#include <algorithm>
#include <cmath>

namespace ferrule {

Eigen::Matrix<double, kRawAxes, 1> Mapping::deflection(const RawCounts& counts) const noexcept {
  Eigen::Matrix<double, kRawAxes, 1> d = Eigen::Matrix<double, kRawAxes, 1>::Zero();
  for (std::size_t axis = 0; axis < kRawAxes; ++axis) {
    const auto k = static_cast<Eigen::Index>(axis);
    if (!(limit[axis] > 0)) continue;
    const double from_centre = (counts[k] - centre[axis]) / limit[axis];
    const double size = (std::abs(from_centre) - dead_zone) / (1 - dead_zone);
    d[k] = std::copysign(std::clamp(size, 0.0, 1.0), from_centre);
  }
  return d;
}

}  // namespace ferrule
