// The minimum of a sub-step: predictor, corrector and Newton's method, limits of friction settled.
#pragma once

#include "sim/minimum.hpp"

namespace ferrule {

inline constexpr double kSnap = 10;  // a snap moves the end by so many times the command's way

// From `state` over dt [s] to the command of `frozen`, at `few` evaluations at most to the first
// minimum and `most_evaluations` with what follows. Freezes the coefficients again where the end
// slides off an edge. With an `event`, the sub-step may be divided: it is given up, and that is the
// part of it at which something seems to happen.
Minimum solve_sub_step(const World& world, const State& state, double dt, int few,
                       int most_evaluations, double* event, FrozenCoefficients& frozen) noexcept;

// A search that ended early may have begun where the prediction was, higher than the end is, or
// have gone astray, far farther than the hand is: the end stays where it was then. A sharp one that
// fell off the face, where bore and cone are not looked at, may end deep in them: it goes on from
// the edge.
void stay_if_astray(const World& world, const State& state, const Pose& command, double dt,
                    int most_evaluations, FrozenCoefficients& frozen, Minimum& found) noexcept;

}  // namespace ferrule
