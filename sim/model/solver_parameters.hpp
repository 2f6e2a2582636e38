// The numerical parameters of the step, together: what each means, where it comes from, and what
// breaks if it is halved or doubled. `ferrule bench parameters` measures that: it changes one at a
// time, and prints what a step costs and how far it ends from one that is solved much further.
//
// Whoever changes one changes steps. None is a key of the scene: `tangent`, `event_travel_nm` and
// the longest step (sim/model/numerics.hpp) are what a scene asks for.
#pragma once

namespace ferrule {

struct SolverParameters {
  // --- Convergence ---

  // A pose is a solution where the residual is below this part of the sum of all forces [-]. Energies
  // are tables and quadratures good to about as much: tighter stalls in their rounding.
  double force_tolerance = 1e-9;

  // The last Newton step is not evaluated where the residual is below `final_residual` of the sum of
  // all forces [-] and the step below `final_move` of the clearance [-]: Newton's method squares what
  // is left, to some 1e-7 of the forces. Halved, more steps take an evaluation more; doubled, what
  // is left grows fourfold, and at the mouth's edge the branch of a contact may be missed.
  double final_residual = 5e-4;
  double final_move = 1e-4;

  // By how much a friction limit may differ from that of the contact where the step ends [-].
  double friction_tolerance = 1e-4;

  // --- Effort ---

  // The most evaluations of the potential in one step, for each of the world's longest steps in it.
  // A budget of 56 fits the 1 ms of a haptic loop with a margin of ten.
  int max_evaluations = 56;

  // Of these, a sub-step that may still be divided takes at most `divisible_evaluations`: a smooth
  // one takes 1 to 3, so whoever needs more is better divided. `reserved_evaluations` are kept for
  // the last sub-step, which must arrive at the command.
  int divisible_evaluations = 5;
  int reserved_evaluations = 24;

  // --- Sub-steps ---

  // Near the ferrule a sub-step begins with at most this part of the clearance of the command's way
  // [-]: half of it cannot pass from one wall to the other unseen.
  double first_travel = 0.5;

  // The shortest sub-step is this part of the way [-], where the scene asks for no shorter one.
  double shortest_substep = 1.0 / 64;

  // The end snaps where it moves so many times as far as the command [-].
  double snap_ratio = 10;

  // --- Predictor ---

  // A prediction is trusted up to this part of the clearance [-], and corrected where the energy's
  // slope along it has fallen to `predictor_slope` of what it was [-].
  double predictor_trust_radius = 0.1;
  double predictor_slope = 0.3;

  // --- Extrapolation (sim/solver/extrapolation.hpp) ---

  // The trust radius is set so that at its end the error is this part of what is allowed [-]. The
  // error grows with the square of the arc length, and is measured at solved steps alone.
  double extrapolation_error = 0.25;

  // A smooth interval is at most so many times as long as the one before [-]. No whole number, or
  // rounding would decide in which of equal steps it ends.
  double extrapolation_growth = 3.1416;

  // The longest, as a relative change of gaps and depths [-].
  double extrapolation_longest = 0.15;
};

}  // namespace ferrule
