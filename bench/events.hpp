// Does the step decide where the fibre sticks? The same motions at ever finer steps.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bench/cases.hpp"

namespace ferrule {

struct EventRow {
  std::string scene, motion;
  double step_s;
  // From the finest step, largest over all common times and starts: of the end and of the place at
  // the mouth [clearances]; of the force at the holder, over the largest of the motion.
  double pose_difference_clearances, force_difference_relative;
  double share_above_1_percent;  // of the common times, at which forces differ by more than that
  double us_per_simulated_s;
  long not_converged, capped;
};

// Every shipped scene, in all motions of bench/random_scene.hpp, at 1, 1/2, ... 1/64 ms.
std::vector<EventRow> bench_events(std::uint64_t seed, std::size_t starts,
                                   const std::vector<std::string>& scenes, const GoOn& go_on = {});

}  // namespace ferrule
