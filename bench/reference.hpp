// The reference for trajectories: SUNDIALS CVODE (BDF, variable order and step) at tight tolerance
// on the same equations that the simulator steps.
//
//   quasi-static:  C(q) dq/dt = -dU/dq(q, hand(t))                 needs drag, so that C is regular
//   inertial:      M d2q/dt2 = -dU/dq(q, hand(t)) - C(q) dq/dt
//
// Without friction, and on the branches and with the bridge of the start. Only cvode.cpp knows
// SUNDIALS; it is a library of its own, loaded when first needed.
#pragma once

#include <functional>
#include <vector>

#include "sim/model/world.hpp"

namespace ferrule {

// Poses of the fibre's end at `times` [s], rising, all > 0; `hand(t)` is the command. Throws
// std::runtime_error if CVODE gives up, BadInput if the program was built without SUNDIALS.
std::vector<Pose> reference_trajectory(const World& world, const State& start,
                                       const std::function<Pose(double)>& hand,
                                       const std::vector<double>& times);

// The same function in the library of its own.
using ReferenceTrajectory = decltype(&reference_trajectory);

}  // namespace ferrule
