// The forces between fibre and bore at a gap, an inserted length and a penetration that are given:
// the curves of the paper's Figs. 5 to 7. Nothing moves or is in equilibrium here.
#pragma once

#include <optional>

#include "sim/world.hpp"

namespace ferrule {

// Along the line of the smallest gap, attraction negative [N]; friction, the meniscus' pull into
// the bore and drag are magnitudes. Zero for what the world does not model.
struct GapForces {
  double van_der_waals = 0, electrostatic = 0, capillary = 0, gravity = 0;
  double adhesion = 0, wall = 0, friction = 0;  // where in contact
  double meniscus = 0;                          // along the bore
  double drag = 0, squeeze = 0;  // along the bore, and of the film between fibre and near wall
};

// How the fibre lies and moves where forces are asked for.
struct Lie {
  double tilt = 0;   // between the axes [rad], >= 0: the gap is then the smallest, at one end
  double speed = 0;  // along the bore for `drag`, towards the near wall for `squeeze` [m/s]
};

// At gap and inserted length >= 0 [m]; `depth` is the penetration of a closed contact [m], >= 0,
// empty where fibre and bore are apart. A liquid bridge is there up to its rupture. The corrected
// laws are integrated along a tilted fibre; the printed ones, and drag, know the gap at its middle,
// gap + length tilt/2. That must not exceed the clearance, or the gap would not be the smallest.
GapForces gap_forces(const World& world, double gap, double length, std::optional<double> depth,
                     const Lie& lie = {});

}  // namespace ferrule
