// The corrected capillary bridge (4c) along a tilted fibre.
//
// Its energy per length w(h) is integrated over the inserted length where the gap h = c - |e(s)| is
// below the bridge's range; there the force jumps to nothing. Gauss-Legendre nodes, those of the
// world and at least 5, in each part between cuts, which are made where the law ends or bends. The
// nodes move with the cuts, so that the gradient is that of the sum at any order; the Hessian is
// the integral's, with f(range) (dh/dq)(dh/dq)^T/|dh/ds| at each end that moves, |dh/ds| of no less
// than a thousandth of the clearance over the length. With 5 nodes force and moment are within
// 1e-3 of the integral, whatever the bridge's volume.
#pragma once

#include "sim/geometry/energy.hpp"
#include "sim/model/world.hpp"

namespace ferrule {

// Adds it to `total`, and its gradient to `gradient`. `law` is that of the world; `bridge`: liquid
// spans the gap; `length` [m], > 0, is inserted at `tip`, and changes by `per_x` with x.
void add_tilted_bridge(Energy& total, PoseVector& gradient, const Capillary& law,
                       const World& world, bool bridge, const PoseVector& tip, double length,
                       double per_x) noexcept;

}  // namespace ferrule
