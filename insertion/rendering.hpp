// Can a scene be felt on a device? The felt stiffness of an insertion
// (sim/solver/held_stiffness.hpp, scaled) against what the device renders stably
// (haptic/stability.hpp).
#pragma once

#include <string>
#include <vector>

#include "haptic/stability.hpp"
#include "insertion/stiffness_range.hpp"

namespace ferrule {

struct Rendering {
  StiffnessRange tip;                // over the scene's states
  double magnified;                  // alpha_f / alpha_x [-]
  double stiffness, damping;         // felt: K [N/m], B [N s/m]
  std::vector<std::string> reasons;  // why the device cannot render them; empty where it can
  // The largest scaling.hand_force_N that is stable, in three digits [N]; 0 or infinite where
  // nothing is, or all.
  double largest_hand_force;

  bool stable() const noexcept { return reasons.empty(); }
  // "--set scaling.hand_force_N=..."; empty where there is none to name.
  std::string set() const;
};

// `go_on` as in insertion_stiffness().
Rendering rendering(const Scene& scene, const DeviceProfile& device,
                    const std::function<bool(std::size_t done, std::size_t all)>& go_on = {});

// The device as the hand's world has it where its grip moves the hand `gain` > 0 times as far: a
// fibre feels that much stiffer at the grip, which is the same as a device that much less damped.
DeviceProfile at_gain(DeviceProfile device, double gain) noexcept;

}  // namespace ferrule
