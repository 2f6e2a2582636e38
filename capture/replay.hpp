// Playing an episode again: the simulator driven by the recorded hand.
#pragma once

#include <optional>
#include <string>

#include "capture/episode.hpp"

namespace ferrule {

// Drives the simulator through the recorded hand poses and compares every number of every row, then
// the outcome; with a tolerance, against the largest number of its unit in its block. The command
// of the last row is the hand's: nothing follows from it here. Throws BadInput if the scene is not
// valid.
void verify(const EpisodeRows& episode, Verification& comparison);
// The first difference, of every bit.
std::optional<Difference> verify(const EpisodeRows& episode);

// The step of an episode that ends at a row, or else the first of those that take the most
// evaluations, taken again with a trace. Throws BadInput if the scene is not valid.
struct TracedStep {
  State before;
  StepResult result;
  double dt;  // [s]
  StepTrace trace;
};
TracedStep trace_step(const EpisodeRows& episode, std::optional<Eigen::Index> row);

}  // namespace ferrule
