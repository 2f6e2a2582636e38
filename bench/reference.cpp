#include "bench/reference.hpp"

#include "learn/loaded_library.hpp"

namespace ferrule {

std::vector<Pose> reference_trajectory(const World& world, const State& start,
                                       const std::function<Pose(double)>& hand,
                                       const std::vector<double>& times) {
  static const auto trajectory = *static_cast<const ReferenceTrajectory*>(loaded_symbol(
      "ferrule_cvode.so", "ferrule_reference_trajectory", built_with("CVODE", "libsundials-dev")));
  return trajectory(world, start, hand, times);
}

}  // namespace ferrule
