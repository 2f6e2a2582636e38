// The scaling between hand and tip of a scene.
#pragma once

#include "haptic/scaling.hpp"
#include "sim/scene/scene.hpp"

namespace ferrule {

inline Scaling scene_scaling(const Scene& scene) noexcept {
  const ScalingRanges& r = scene.scaling;
  return Scaling::from_ranges(r.hand_range, r.tip_range, r.hand_force, r.tip_force);
}

}  // namespace ferrule
