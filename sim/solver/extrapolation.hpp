// Extrapolation over smooth intervals.
//
// Where nothing happens the fibre follows its holder as
//   d tip = (H + K)^-1 K d command,
// with K the holder's stiffness and H the Hessian of all other forces, with friction and how its
// limits change with the depth of the contacts. In a world that asks for it
// (Numerics::extrapolation_tip) a step on a smooth interval is that product and no more: pose,
// holder's force, contacts and sliding friction move along. With drag the fibre lags behind, and
//   d tip_n = (H + K + D/dt)^-1 (K d command_n + D/dt d tip_n-1)
// in steps of one length. So does friction across the sliding direction, which is that of a step
// and not of the path: of the lateral slip s after a step the part s L/l goes on, where L is the
// elastic slip at the limit, and l what the slip was before it slid.
//
// An interval ends, and the step is solved (sim/solver/step.cpp), where
//   an open contact would close, a sticking one slide, a sliding one turn back, or a bridge begin
//   or end,
//   the end comes near an edge of the ferrule, or
//   the arc length exceeds the trust radius.
// The extrapolation's error is measured where an interval ends, grows with the square of the arc
// length, and so sets the next trust radius. After an event every step is solved until two agree
// with the extrapolation.
//
// For quasi-static worlds without flow, and an end in the bore or in its cone; all others are
// solved step by step.
#pragma once

#include "sim/solver/newton.hpp"
#include "sim/solver/step.hpp"

namespace ferrule {

// A step from now.state, in place, without an evaluation of the potential. False, with `now` as it
// was, where it has to be solved.
bool extrapolate(const World& world, const Pose& command, double dt, StepResult& now,
                 StepTrace* trace) noexcept;

// now.state where its extrapolation, if there is one, ends: contacts have their depth there, and
// the elastic slip that they had. Where a contact moves on over the fibre that is more than a
// slide, to first order, tells.
State end_extrapolation(const World& world, const StepResult& now) noexcept;

// For a step that has been solved, from `before`: the extrapolation there, with its trust radius.
void set_extrapolation(const World& world, const FrozenCoefficients& frozen, const Iterate& iterate,
                       double dt, StepResult& now) noexcept;
void set_trust_radius(const World& world, const State& before, const Extrapolation& last,
                      StepResult& now) noexcept;

}  // namespace ferrule
