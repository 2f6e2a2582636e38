// How a world is computed: what changes cost and error, and nothing of the physics.
#pragma once

#include <limits>

#include "sim/laws/quadrature.hpp"
#include "sim/model/solver_parameters.hpp"

namespace ferrule {

enum class Integrator { backward_euler, bdf2 };

struct Numerics {
  Integrator integrator = Integrator::backward_euler;
  double longest_step = std::numeric_limits<double>::infinity();  // longer ones are divided [s]
  // A step in which a contact or bridge opens or closes, or the fibre snaps, is divided until the
  // command travels no more than this in it [m].
  double event_travel = std::numeric_limits<double>::infinity();
  // Where these are not 0, steps are extrapolated over smooth intervals
  // (sim/solver/extrapolation.hpp), to about this error of the end [m] and of the force at the
  // holder [N]; else every step is solved.
  double extrapolation_tip = 0, extrapolation_force = 0;
  Quadrature quadrature;  // of surface forces along the inserted length
  // Corrected van der Waals and electrostatic forces in closed form instead
  // (sim/terms/surface_forces.hpp).
  bool closed_form = true;
  SolverParameters solver;
};

}  // namespace ferrule
