// The stiffness that a hand meets over a whole insertion (sim/solver/held_stiffness.hpp).
#pragma once

#include <cstddef>
#include <functional>

#include "sim/scene/scene.hpp"

namespace ferrule {

// The positions' part of K over many states of insertions into `scene`, tilts held by the hand
// (which is stiffer than letting them go).
struct StiffnessRange {
  double largest = 0;         // largest eigenvalue in any state [N/m], >= 0
  double smallest = 0;        // smallest: attraction where negative [N/m]
  double damping = 0;         // largest eigenvalue of B in any state [N s/m], >= 0
  State stiffest;             // where K is largest
  std::size_t states = 0;     // looked at
  std::size_t touching = 0;   // of these, with one contact or two
  std::size_t two_point = 0;  // of these, with end and side touching at once
};

// Deterministic, some thousand states, 100,000 at most: the start, the way to the axis and to the
// success depth, at half of it and at it pushes sideways and tilts to both sides (two-point
// contact), and the end pressed on the lead-in cone and on the front face. Every motion ends where
// the force at the holder, weight apart, exceeds limits.force. `dt` [s], > 0, is the period that B
// is for. `go_on` is told how many of all motions are done; false ends it there.
StiffnessRange insertion_stiffness(
    const Scene& scene, double dt,
    const std::function<bool(std::size_t done, std::size_t all)>& go_on = {});

}  // namespace ferrule
