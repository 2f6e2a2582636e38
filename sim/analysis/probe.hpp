// The motions that a plan (sim/analysis/plan.hpp) is measured on.
#pragma once

#include <cstdint>
#include <vector>

#include "sim/scene/scene.hpp"

namespace ferrule {

inline constexpr double kSpeedingUp = 0.1;  // time in which a command changes its speed [s]

struct Probe {
  State start;
  std::vector<Pose> hand;  // one per millisecond, the first that of `start`
};

// How many of them a scene needs: fewer where it rings, and is stepped much finer.
std::uint64_t probes_of(const Scene& scene) noexcept;

// Number k of a scene, deterministic: to the mouth, in, pushes in two directions with a tilt, half
// way out while pressed, and out; every fourth straight down from a start of the scene.
Probe make_probe(const Scene& scene, std::uint64_t k);

}  // namespace ferrule
