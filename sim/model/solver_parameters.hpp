// The numerical parameters of the step (sim/solver/), together: what each means, where it comes
// from, and what changes if it is halved or doubled. The latter is measured by
//   ferrule bench parameters --scenes 3 --seed 2
// over all shipped scenes: evaluations per step (0.458 as they are), steps at the iteration limit
// (14 of all), and how far 99 % of the steps end from a strict one (1.1e-5 clearances). "Nothing"
// means that evaluations and error change by no more than a hundredth, and the steps at the limit
// by no more than two.
//
// A change of any changes steps and thus recordings. None is a key of the scene: a scene asks for
// an error (`tangent`, `event_travel_nm`, the longest step: sim/model/numerics.hpp).
#pragma once

namespace ferrule {

struct SolverParameters {
  // --- Convergence ---

  // A pose is a solution where the residual is below this part of the sum of all forces [-].
  // Energies are tables and quadratures that are good to about as much. Halved or doubled: nothing,
  // as nearly all steps end by `final_residual`.
  double force_tolerance = 1e-9;

  // The last Newton step is not evaluated where the residual is below `final_residual` of the sum
  // of all forces [-] and the step below `final_move` of the clearance [-]: Newton's method squares
  // what is left, to some 1e-7 of the forces. Halved or doubled: nothing.
  double final_residual = 5e-4;
  double final_move = 1e-4;

  // By how much a friction limit may differ from that of the contact where the step ends, of itself
  // [-]. Halved: nothing; doubled, 99 % of the steps end within 3.8e-6 clearances.
  double friction_tolerance = 1e-4;

  // --- Effort ---

  // The most evaluations of the potential in one step, for each of the world's longest steps in it.
  // It bounds the time of the worst step. Halved, four times as many steps end at the limit, and
  // the worst ends 2.5 times as far off; doubled, half as many.
  int max_evaluations = 56;

  // A sub-step that may still be divided takes at most so many: a smooth one takes 1 to 3, so what
  // needs more is better divided. Halved or doubled: nothing.
  int divisible_evaluations = 5;

  // So many are kept for the last sub-step, which must arrive at the command. Halved: nothing;
  // doubled, 1 % fewer evaluations and events that are located less well: with `--scene bench`
  // alone the worst step ends 0.96 clearances off instead of 0.011.
  int reserved_evaluations = 24;

  // --- Sub-steps ---

  // Near the ferrule a sub-step begins with at most this part of the clearance of the command's
  // travel [-]: no more can pass from one wall to the other unseen. For hands faster than those of
  // the shipped scenes at 1 kHz, in which halved or doubled changes nothing.
  double first_travel = 0.5;

  // The shortest sub-step is this part of the path [-], where the scene asks for no shorter one.
  // Halved or doubled: nothing.
  double shortest_substep = 1.0 / 64;

  // The end snaps where it moves so many times as far as the command [-]. Halved or doubled:
  // nothing.
  double snap_ratio = 10;

  // --- Predictor ---

  // A prediction is trusted up to this part of the clearance [-]. Halved, a fifth more evaluations
  // (in `bench` twice as many); doubled, 6 % fewer at the same error.
  double predictor_trust_radius = 0.1;

  // It is corrected where the energy's slope along it has fallen to this part [-]; else the search
  // begins again where the step did. Halved, 1 % more evaluations; doubled, nothing.
  double predictor_slope = 0.3;

  // --- Extrapolation (sim/solver/extrapolation.hpp) ---

  // The trust radius is set so that at its end the error is this part of what is allowed [-]: the
  // error grows with the square of the arc length, and is measured at solved steps alone. Halved,
  // 13 % more evaluations and errors smaller by a sixth; doubled, 12 % fewer and errors 1.6 times
  // as large.
  double extrapolation_error = 0.25;

  // A smooth interval is at most so many times as long as the one before [-]. No whole number, or
  // rounding would decide in which of equal steps it ends. Halved or doubled: nothing.
  double extrapolation_growth = 3.1416;

  // The longest, as a relative change of gaps and depths [-]. Halved, 1 % more evaluations;
  // doubled, nothing.
  double extrapolation_longest = 0.15;
};

}  // namespace ferrule
