// The numbers of the search by touch: its gains, which a file states, and its constants, which stand
// here alone. Each line says the unit, what the constant is, and where it comes from. "By trials"
// means that it was chosen by what it does on the rungs of the ladder (data/scenes/ladder): how many
// trials end inserted, how soon, and with what force.
//
// A unit is of the SI, or [1], or one of these: a gain, by its symbol; sd, a standard deviation of
// the sensor's noise; d, the delay or lag of the hand; f, the force that counts as a touch; p, the
// play of the end in the cone.
#pragma once

// As kSearchGains (controller/search_law.hpp). data/controllers/search.json has the source of each.
typedef struct {
  double approach_speed, touch_speed, insert_speed;                // v_a, v_t, v_i [m/s]
  double tilt_rate;                                                // w [rad/s]
  double touch_force, push_force;                                  // F_t, F_p [N]
  double turn_moment;                                              // M_t [N m]
  double hold_time;                                                // t_h [s]
  double lift;                                                     // l [m]
  double tilt;                                                     // theta [rad]
  double yield;                                                    // A [m/(s N)]
  double near_entrance;                                            // d_e [m]
  double fibre_radius, bore_radius, mouth_radius, lead_in_length;  // r, R, R_m, l_m [m]
} ferrule_numbers;

// What it feels.

// [sd] Noise alone reaches no more. Of normal noise it does once in 1e9 readings.
static const double ferrule_noises = 6;
// [sd] The same of the smoothed wrench. By trials.
static const double ferrule_smooth_noises = 2;
// [1] Share of a new reading in that. By trials.
static const double ferrule_smoothing = 0.05;
// [F_p] More than this counts as a touch whatever the noise. By trials.
static const double ferrule_most_felt = 0.5;
// [f] With less it does not touch, or no longer. By trials.
static const double ferrule_unfelt = 0.5;
// [1] Sideways over axial force: with more it lies on a slope. By trials.
static const double ferrule_slides = 0.5;

// How it rests, and gives way the first time.

// [t_h] So long it rests before the force counts. By trials.
static const double ferrule_settling = 0.4;
// [f] Standard deviation of a mean force that is to tell the stiffness. By trials.
static const double ferrule_force_error = 0.02;
// [v_t] It gives way so fast. By trials.
static const double ferrule_releasing = 0.25;
// [1] Until no more than this is left of the force. By trials.
static const double ferrule_left = 0.4;
// [1] The mean force after it, over that before: less is enough. By trials.
static const double ferrule_released = 0.7;

// How it goes to a place.

// [l] So far above what can be in the way it goes fast. By trials.
static const double ferrule_clear = 0.25;
// [l] So far it comes off gently. By trials.
static const double ferrule_gently = 0.1;
// [r] Nearer to a place it is there. By trials.
static const double ferrule_there = 1e-3;
// [theta] The same of a tilt. By trials.
static const double ferrule_tilted = 0.01;
// [s] The time constant with which it settles at a place. By trials.
static const double ferrule_place_time = 0.01;
// [d] But at least this: a delay does not overshoot from e on.
static const double ferrule_place_lags = 2.7;
// [s] The same at the tilt with which it inserts. By trials.
static const double ferrule_tilt_time = 0.1;
// [s] The same as it comes down to touch. By trials.
static const double ferrule_brake_time = 2e-3;
// [d] But at least this: a lag of first order does not overshoot from 4 on.
static const double ferrule_brake_lags = 4;

// How late the hand is, and what that allows.

// [s] So long it is measured at least. By trials.
static const double ferrule_measured_time = 0.25;
// [d] And so long. By trials.
static const double ferrule_measured_delays = 5;
// [1] The gain is this or its inverse at most: what moves less is held back. By trials.
static const double ferrule_most_gain = 2;
// [s] F_p/(k v_t) of a holder of unknown stiffness: 40 uN at 14 um/s and 1 mN/um, as the touching
// speed assumes.
static const double ferrule_stop_time = 2.86e-3;
// [F_p] A touch may come to this. By trials.
static const double ferrule_stop_force = 0.95;
// [F_p] With more it does not insert, pull or turn: 54 uN, nine tenths of the force limit of bench.
static const double ferrule_hardest = 1.35;
// [1] Of the force limit that the trial states: it inserts and turns with no more. The same share.
static const double ferrule_of_limit = 0.9;
// [F_p] What it goes on by may add this in the bore. By trials.
static const double ferrule_steady_force = 0.25;
// [l] Or be so long. By trials.
static const double ferrule_stop_lift = 0.5;

// How it centres in a cone.

// [l_m] Its height the first time. By trials.
static const double ferrule_centre_at = 0.5;
// [l_m] Its height the second time, at least and at most. By trials.
static const double ferrule_centre_above = 0.15, ferrule_centre_below = 0.45;
// [1] The play there, over how far the cone held it the first time. By trials.
static const double ferrule_held_play = 1.3;
// [p] Where it feels no cone in so long a way there is none: the play is on both sides.
static const double ferrule_no_cone = 2;
// [d_e] From here on a touch is to be expected, once the entrance's height is known. By trials.
static const double ferrule_before = 0.3;
// [1] What a cone may be higher, over what it is taken to be. By trials.
static const double ferrule_further = 1.25;

// What the touches tell.

// [r] Standard deviation of a touch's height: 6 nm of a fibre. By trials.
static const double ferrule_height_noise = 1e-4;
// [rad] That of an end's slope: cleaves are good to 1 degree.
static const double ferrule_slope_noise = 0.02;
// [1] That of the logarithm of a bore's clearance over its nominal one. By trials.
static const double ferrule_bore_noise = 0.7;
// [1] That of the logarithm of the play in a cone. By trials.
static const double ferrule_mouth_noise = 0.01;
// [rad] No end is steeper: nearly twice such a cleave.
static const double ferrule_steepest = 0.03;
// [1] No opening explains a misfit of so many standard deviations of a height. By trials.
static const double ferrule_misfit = 10;
// [theta] How far the sides are apart at most. By trials.
static const double ferrule_furthest_apart = 4;
// [1] An end's slope over the tilt to the sides: with more it rests on one of them. By trials.
static const double ferrule_one_side = 0.5;
// [l] So much lower than on the face it is on an edge. By trials.
static const double ferrule_on_edge = 0.1;
// [l] So much lower it is in a cone: a bore without one lets it no deeper. By trials.
static const double ferrule_in_cone = 2;
// [1] So often in a row it may be on an edge without a cone. By trials.
static const int ferrule_edges = 2;

// How it inserts.

// [s] It looks so often whether it is held up. By trials.
static const double ferrule_look_time = 0.1;
// [d] But no more often: a late hand sets out late. By trials.
static const double ferrule_look_lags = 1.5;
// [v_i] Slower it is held up. By trials.
static const double ferrule_slow = 0.1;
// [l] No further below where it can rest, the face holds it up. By trials.
static const double ferrule_shallow = 3;
// [F_p] Before it turns, less is left. By trials.
static const double ferrule_freed = 0.5;
// [w] It turns so fast. By trials.
static const double ferrule_turning = 0.5;
// [1] But so much slower where it presses. By trials.
static const double ferrule_least_turning = 0.2;
// [rad] It turns no further. By trials.
static const double ferrule_most_tilt = 0.02;
// [1] The push once it is straight, over that before. By trials: of f 90 instead of 88 %.
static const double ferrule_more = 1.15;
