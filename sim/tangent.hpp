// Smooth stretches, followed along the tangent.
//
// Where nothing happens the fibre follows its holder as
//   d tip = (H + K)^-1 K d command,
// with K the holder's stiffness and H the Hessian of all other forces, friction and how its limits
// change with the depth of the contacts included. In a world that asks for it
// (Numerics::tangent_tip) a step that stays on a smooth stretch is that product and no more: pose,
// holder's force, contacts and what slips are moved on. With drag the fibre lags behind, and
//   d tip_n = (H + K + D/dt)^-1 (K d command_n + D/dt d tip_n-1)
// in steps of one length. So does friction across the slip, whose direction is that of a step and
// not of the way: of the stretch s that the spring of a contact has across after a step, it goes on
// with the part s L/l, where L is what it is stretched to and l what it was before it slipped.
//
// A stretch ends, and the step is solved (sim/step.cpp), where
//   an open contact would close, a stuck one slip, a slipping one turn back, or a bridge begin or
//   end,
//   the end comes near an edge of the ferrule, or
//   the command has gone as far as the tangent is good for. That is measured where the stretch
//   ends: what the tangent has missed there says, growing with the square of the way, how long the
//   next one may be. After an event every step is solved until two agree with the tangent.
//
// Quasi-static worlds without flow, and an end in the bore or in its cone; all others are solved
// step by step.
#pragma once

#include "sim/minimum.hpp"
#include "sim/step.hpp"

namespace ferrule {

// A step along the tangent.
struct TangentStep {
  Pose move;
  double way;                                   // Tangent::way after it
  std::array<double, kContactPlaces> deeper{};  // [m]
  std::array<Vector3d, kContactPlaces> slid = {Vector3d::Zero(), Vector3d::Zero()};  // [m]
};

// That from a `state` with a tangent to `command`; nothing where the step has to be solved.
std::optional<TangentStep> along_tangent(const World& world, const State& state,
                                         const Pose& command, double dt) noexcept;
// Takes it from now.state, in place.
void follow_tangent(const World& world, const Pose& command, double dt, const TangentStep& next,
                    StepResult& now) noexcept;

// From where a step that is solved, over Tangent::dt, ends where one along the tangent did.
State before_tangent_step(const World& world, const State& state) noexcept;

// Before a step that is solved: a state on a tangent without it, and what rubs as stretched as it
// was: where a contact moves on over the fibre that is more than a slide, to first order, tells.
void leave_tangent(const World& world, State& state) noexcept;

// For a step that has been solved, from `before`: the tangent there, with its reach.
void set_tangent(const World& world, const FrozenCoefficients& frozen, const Minimum& found,
                 double dt, State& state) noexcept;
void set_reach(const World& world, const State& before, StepResult& result) noexcept;

}  // namespace ferrule
