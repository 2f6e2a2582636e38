// Runs along given commands, one per millisecond, and how far one is from another.
#pragma once

#include <functional>
#include <vector>

#include "sim/model/world.hpp"
#include "sim/solver/step.hpp"

namespace ferrule {

struct SampledRun {
  std::vector<Vector3d> tip;    // [m]
  std::vector<Vector3d> force;  // at the holder [N]
};

using WatchSample = std::function<void(const StepResult&)>;

// The first sample is the state at hand[0]. The run ends early where the holder's force, weight
// apart, exceeds `force_limit` [N]. `watch`, if any, is shown every sample.
SampledRun sample_run(const World& world, const State& start, const std::vector<Pose>& hand,
                      double force_limit, const WatchSample& watch = nullptr);

// Of the holder's forces [N].
double largest_force(const SampledRun& run);

// Whether the end ever moves by far more than the command does.
bool snaps(const SampledRun& run, const std::vector<Pose>& hand, double clearance);

// Error of a run against that of the full model, sample by sample, the larger of
//   |tip - tip_full| over the clearance
//   |F - F_full| of the holder over the largest |F_full| of that run, or over the force that moves
//     the holder by a clearance where that is more
// An event, such as a snap into contact, is resolved to one sample in time; where it comes later,
// the travel of the command until then, over the clearance, counts as the error. Over the samples
// of the shorter run.
double run_error(const SampledRun& run, const SampledRun& full, const std::vector<Pose>& hand,
                 const World& world);

}  // namespace ferrule
