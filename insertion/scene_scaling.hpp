// What a scene tells a hand: the scaling between hand and tip, and how far to push.
#pragma once

#include <algorithm>

#include "haptic/scaling.hpp"
#include "sim/scene/scene.hpp"

namespace ferrule {

inline Scaling scene_scaling(const Scene& scene) noexcept {
  const ScalingRanges& r = scene.scaling;
  return Scaling::from_ranges(r.hand_range, r.tip_range, r.hand_force, r.tip_force);
}

// Where a hand takes the bore's entrance to be, in the hand's world, the true one being at 0 [m].
inline double registered_entrance(const Scene& scene) noexcept {
  return scene_scaling(scene).motion * scene.sensor.entrance_error;
}

// How far past the success depth a hand means to push [m]: a tenth of it, and 2 um at least, for
// friction and the holder's give take some tenths of a micrometre.
inline double overshoot(const Scene& scene) noexcept {
  return std::max(0.1 * scene.success.depth, 2e-6);
}

}  // namespace ferrule
