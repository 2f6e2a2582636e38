// A trial before any hand moves: what chance decides of it, and what follows from its scene.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "haptic/scaling.hpp"
#include "sim/scene/force_sensor.hpp"
#include "sim/scene/scene.hpp"

namespace ferrule {

struct TrialSetup {
  std::shared_ptr<const Scene> scene;  // with the numbers that were drawn
  State start;                         // of the fibre, at rest
  ForceSensor sensor;                  // with the errors that it has in this trial
  Scaling scaling;                     // between hand and tip
  std::uint64_t seed = 0, trial = 0;
  std::size_t infeasible = 0;  // trials before it that feasible_setup put aside

  // Where the hand holds the fibre of `start` [m, rad, hand's world].
  HandPose hand() const noexcept { return scaling.motion_to_hand(start.command); }
};

// Trial `trial` under `seed`; empty where its parts cannot be together. What is named `redrawn` (a
// drawn number, or one of kDrawnBesides) is as under another seed while all else stays as it is. A
// scene that draws nothing, such as that of a recording, must outlive it.
std::optional<TrialSetup> trial_setup(const Scene& scene, std::uint64_t seed, std::uint64_t trial,
                                      const std::string& redrawn = "");

// The first whose parts can be together, as feasible_trial of sim/scene/draw.hpp has it. Throws as
// that.
TrialSetup feasible_setup(const Scene& scene, std::uint64_t seed, std::uint64_t trial);

}  // namespace ferrule
