// An insertion that finds the bore by touch, without learning. It needs the axial force, tilt as an
// action, and its own motion remembered; no moments before it is in the bore.
//
//   approach     rests for t_h, then goes straight in, slower near where the entrance is taken to
//                be, until it is felt: an axial force above F_t, or above what the sensor's noise
//                in free air ever reaches
//   touch        rests for t_h, longer where the sensor is noisy, and takes the mean axial force f;
//                the end is at x = x_hand + f/k. The first time it gives way (release) until less
//                than half of f is left, and rests again: that gives the stiffness k. An end that
//                is pushed aside lies on a slope and goes on to insert.
//   lift         off by l, gently at first, further where something still holds it, or on into the
//                bore where that holds it too well; move to the next place (touch search); lower:
//                fast where nothing can be in the way, then at the touching speed. An end that comes
//                lower than the face lets it is in the opening.
//   insert       v_x = -v_i (1 - |f|^2/F_p^2), not backwards and of f_x only what presses,
//                v_y = A f_y, v_z = A f_z, upright. Held up at the face it touches there; held up
//                in the bore:
//   back off     by l at least, until nothing presses; straighten: tilts to one side and to the
//                other until the bore resists with a moment M_t, about each axis, and inserts on in
//                the middle, with F_p larger by 15 %, and by 35 % at most. A tilt moves the
//                fibre's side along the wall, by r for a radian; it gives way along the bore to
//                what that adds.
//
// A holder that moves later than it is told to, or by another amount, shows that in free air: after
// T, on its way at one speed that has become g v where v was meant, it has moved by g v (T - d).
// From then on it is told to move by 1/g of what is meant. With a delay or a lag d > 0 speeds are
// such that what it goes on by after a touch, v d, brings the force to F_p at most (k is taken
// as 1 mN/um, as the touching speed assumes, until it is known; who knows k at first approaches so,
// too); and it keeps away from a cone until it is near the axis:
//   centre       half way down the lead-in, and again near its end, it moves sideways until the cone
//                resists (cone centre). How far it could move there tells how high the cone is.
//
// Forces are relative to their mean in free air. Lengths and speeds are of the hand.
#pragma once

#include "controller/search/cone_centre.h"
#include "controller/search/hand_response.h"
#include "controller/search/touch_search.h"

typedef enum {
  FERRULE_APPROACH,
  FERRULE_CENTRE,
  FERRULE_TOUCH,
  FERRULE_RELEASE,
  FERRULE_LIFT,
  FERRULE_MOVE,
  FERRULE_LOWER,
  FERRULE_INSERT,
  FERRULE_BACK_OFF,
  FERRULE_STRAIGHTEN
} ferrule_phase;

// As kSearchGains (controller/search_law.hpp).
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

typedef struct {
  ferrule_axes wrench;        // relative to that at rest at the start [N, N m]
  ferrule_axes displacement;  // since the start [m, rad]
  double height;              // before where the entrance is taken to be [m]; < 0 past it
  double time;                // since the start [s]
} ferrule_observed;

typedef struct {
  ferrule_numbers n;
  double known_stiffness;  // of the holder along the bore [N/m]; 0: not known before a touch
  ferrule_touches touches;
  ferrule_phase phase;
  double since;       // its begin [s]
  ferrule_axes from;  // and the displacement then

  ferrule_axes tare;   // mean of what was read in free air
  ferrule_axes noise;  // mean squares of what was read there
  int free;            // readings there
  ferrule_hand hand;
  ferrule_axes smooth;  // of the last readings, less the tare

  double sum;                  // of the axial force at rest [N]
  int read;                    // readings of it
  double stiffness;            // k [N/m]; 0: not known yet
  double rest_at, rest_force;  // of the first touch: x of the hand [m], f [N]

  double push;    // with which it inserts [N]
  int to_centre;  // how often still; 0 where there is no cone
  ferrule_cone cone;
  bool at_cone;           // it touches it still
  double held;            // how far from there the cone held it [m]
  double entrance;        // its height where it was taken to be at 0 [m]
  double before, behind;  // up to which heights before and behind it a touch is to be expected [m]
  bool relaxed;           // along the bore, before it turns
  int probe;              // of six: about each axis one way, the other way, the middle
  double resisted[2];     // at which tilts [rad]
  ferrule_v2 straight;    // the tilt to insert with [rad]
} ferrule_search;

// Of what it feels.
static const double ferrule_noises = 6;  // standard deviations of the sensor that it does not reach
static const double ferrule_smooth_noises = 2;   // the same of the smoothed wrench
static const double ferrule_smoothing = 0.05;    // share of a new reading in that
static const double ferrule_settling = 0.4;      // of the time it rests, before the force counts
static const double ferrule_force_error = 0.02;  // of what is felt, where it tells the stiffness
static const double ferrule_left = 0.4;          // of the force, where it has given way
static const double ferrule_released = 0.7;      // less than that is enough
static const double ferrule_slides =
    0.5;  // of the axial force: with more sideways it is on a slope
static const double ferrule_releasing = 0.25;  // of the touching speed

// Of where it goes.
static const double ferrule_clear = 0.25;       // of the lift: above what can be in the way
static const double ferrule_gently = 0.1;       // of the lift: that far it comes off gently
static const double ferrule_there = 1e-3;       // of r: that near a place it is there
static const double ferrule_tilted = 0.01;      // of the tilt, likewise
static const double ferrule_place_time = 0.01;  // with which it settles at a place [s]
static const double ferrule_tilt_time = 0.1;    // and at a tilt, inserting [s]

// Of a hand that is late.
static const double ferrule_place_lags = 2.7;   // it settles with at least: from e on no overshoot
static const double ferrule_brake_time = 2e-3;  // with which it comes down to touch [s]
static const double ferrule_brake_lags = 4;     // and at least: without overshoot of a lag, too
static const double ferrule_stop_force = 0.95;  // of the pushing force: what a touch may come to
static const double ferrule_hardest = 1.35;  // likewise: with more it does not insert, pull or turn
static const double ferrule_most_felt = 0.5;    // of the pushing force: what it feels at least
static const double ferrule_stop_time = 2.86e-3;  // of touching speed, for the pushing force [s]
static const double ferrule_steady_force = 0.25;  // of the pushing force: may go on in the bore
static const double ferrule_stop_lift = 0.5;      // of the lift, likewise
static const double ferrule_further = 1.25;       // of what a cone may be higher

// Of how it centres in a cone.
static const double ferrule_centre_at[] = {0.5, 0.15};  // of the lead-in's length
static const double ferrule_centre_below = 0.45;        // likewise: the second time
static const double ferrule_held_play = 1.3;  // of how far a touch holds it: there is as much play
static const double ferrule_before = 0.3;     // of near the entrance, once its height is known

// Of how it inserts.
static const double ferrule_look_every = 0.1;  // whether it is held up [s]
static const double ferrule_look_lags = 1.5;   // and in no less: a late hand sets out late
static const double ferrule_held_up = 0.1;     // of the inserting speed: slower than that it is
static const double ferrule_shallow = 3;    // lifts below the face: there the face may hold it up
static const double ferrule_freed = 0.5;    // of the pushing force: less is left before it turns
static const double ferrule_probing = 0.5;  // of the tilt rate
static const double ferrule_more = 1.15;    // of the pushing force before, once it is straight again
static const double ferrule_least_turning = 0.2;  // of that
static const double ferrule_most_tilt = 0.02;     // that it tries, from straight [rad]
enum { FERRULE_PROBES = 6 };

// What somebody knows of his own hand, and others find out: its lag, from what is felt to what the
// holder does [s], and its stiffness; 0: not known.
static inline void ferrule_search_start(ferrule_search* s, const ferrule_numbers* numbers,
                                        double lag, double stiffness) {
  const ferrule_touch_numbers touch = {
      numbers->fibre_radius,  numbers->bore_radius, numbers->mouth_radius, numbers->lead_in_length,
      numbers->near_entrance, numbers->tilt,        numbers->lift};
  memset(s, 0, sizeof *s);
  s->n = *numbers;
  s->known_stiffness = stiffness;
  s->push = numbers->push_force;
  s->to_centre = 2;
  s->before = s->behind = numbers->near_entrance;
  ferrule_touches_start(&s->touches, touch);
  ferrule_hand_start(&s->hand, lag);
}

static inline ferrule_axes ferrule_along(double velocity) {
  const ferrule_axes v = {velocity, {0, 0}, {0, 0}};
  return v;
}

// Stands still for this period.
static inline ferrule_axes ferrule_begin(ferrule_search* s, ferrule_phase phase,
                                         const ferrule_observed* o) {
  s->phase = phase;
  s->since = o->time;
  s->from = o->displacement;
  s->sum = 0;
  s->read = 0;
  s->probe = 0;
  s->relaxed = false;
  if (phase == FERRULE_INSERT) ferrule_straightened(&s->touches);
  return ferrule_along(0);
}

static inline double ferrule_felt_force(const ferrule_search* s) {
  const double above_noise = ferrule_max(s->n.touch_force, ferrule_noises * sqrt(s->noise.x));
  return ferrule_min(above_noise, ferrule_most_felt * s->n.push_force);
}

static inline double ferrule_felt_smooth_force(const ferrule_search* s) {
  return ferrule_max(s->n.touch_force, ferrule_smooth_noises * sqrt(s->noise.x));
}

static inline double ferrule_felt_moment(const ferrule_search* s) {
  const double noise = ferrule_max(s->noise.about.y, s->noise.about.z);
  return ferrule_max(s->n.turn_moment, ferrule_smooth_noises * sqrt(noise));
}

// A speed from which the holder, late as it is, does not go on by more than `further`.
static inline double ferrule_stoppable(const ferrule_search* s, double speed, double further) {
  return speed * s->hand.delay > further ? further / s->hand.delay : speed;
}

static inline double ferrule_stiffness(const ferrule_search* s) {
  if (s->stiffness > 0) return s->stiffness;
  if (s->known_stiffness > 0) return s->known_stiffness;
  return s->n.push_force / (ferrule_stop_time * s->n.touch_speed);
}

// He knows that a push moves his gripper by more than the end is lifted.
static inline bool ferrule_gives_way(const ferrule_search* s) {
  return s->known_stiffness > 0 && s->n.push_force / s->known_stiffness > s->n.lift;
}

// At which a touch that it feels then comes to as much as it may.
static inline double ferrule_touching_from(const ferrule_search* s, double speed) {
  const double further = ferrule_stop_force * s->n.push_force - ferrule_felt_force(s);
  return ferrule_stoppable(s, speed, further / ferrule_stiffness(s));
}

static inline double ferrule_touching(const ferrule_search* s) {
  return ferrule_touching_from(s, s->n.touch_speed);
}

// It has to touch more slowly for its delay.
static inline bool ferrule_late(const ferrule_search* s) {
  return ferrule_touching(s) < s->n.touch_speed;
}

// At which it notices a pull as large as its push.
static inline double ferrule_pulling(const ferrule_search* s) {
  return ferrule_stoppable(s, s->n.touch_speed,
                           (ferrule_hardest - 1) * s->n.push_force / ferrule_stiffness(s));
}

// A tilted end gives way in the bore, and comes to rest in parts of the lift.
static inline double ferrule_inserting(const ferrule_search* s) {
  const double soft = s->stiffness > 0 ? ferrule_steady_force * s->n.push_force / s->stiffness : 0;
  return ferrule_stoppable(s, s->n.insert_speed, ferrule_max(soft, ferrule_stop_lift * s->n.lift));
}

static inline double ferrule_goal_time(const ferrule_search* s) {
  return ferrule_max(ferrule_place_time, ferrule_place_lags * s->hand.delay);
}

static inline ferrule_v2 ferrule_at_most(ferrule_v2 v, double size) {
  const double now = ferrule_norm(v);
  return now > size ? ferrule_times(size / now, v) : v;
}

static inline ferrule_v2 ferrule_sideways_to(const ferrule_search* s, ferrule_v2 place,
                                             const ferrule_observed* o) {
  const ferrule_v2 way = ferrule_difference(place, o->displacement.across);
  return ferrule_at_most(ferrule_over(way, ferrule_goal_time(s)), s->n.insert_speed);
}

static inline ferrule_v2 ferrule_tilted_to(const ferrule_search* s, ferrule_v2 tilt, double time,
                                           const ferrule_observed* o) {
  const ferrule_v2 way = ferrule_difference(tilt, o->displacement.about);
  return ferrule_at_most(ferrule_over(way, time), s->n.tilt_rate);
}

static inline bool ferrule_is_at(const ferrule_search* s, ferrule_v2 place,
                                 const ferrule_observed* o) {
  const ferrule_v2 way = ferrule_difference(place, o->displacement.across);
  return ferrule_norm(way) < ferrule_there * s->n.fibre_radius;
}

// The second time no lower than where the end comes off the cone before it is in the middle.
static inline bool ferrule_time_to_centre(const ferrule_search* s, const ferrule_observed* o) {
  const double length = s->n.lead_in_length;
  if (!(ferrule_late(s) || ferrule_gives_way(s)) || !s->hand.measured || s->to_centre == 0)
    return false;
  if (s->to_centre == 2) return o->height < ferrule_centre_at[0] * length;
  return o->height < ferrule_clamp(ferrule_height_of(&s->touches, ferrule_held_play * s->held),
                                   ferrule_centre_at[1] * length, ferrule_centre_below * length);
}

static inline ferrule_axes ferrule_approach(ferrule_search* s, const ferrule_observed* o) {
  const bool still = o->time < s->n.hold_time;  // at first, for the noise
  const double height = o->height - s->entrance;
  const ferrule_axes f = o->wrench, none = {0, {0, 0}, {0, 0}};
  if (!still && f.x > ferrule_felt_force(s)) return ferrule_begin(s, FERRULE_TOUCH, o);
  if (height < -s->behind) return ferrule_begin(s, FERRULE_INSERT, o);
  ++s->free;
  if (s->free > 1) {
    const ferrule_axes square = {f.x * f.x,
                                 {f.across.y * f.across.y, f.across.z * f.across.z},
                                 {f.about.y * f.about.y, f.about.z * f.about.z}};
    const ferrule_axes more = ferrule_plus(square, -1, s->noise);
    s->noise = ferrule_plus(s->noise, 1, ferrule_axes_over(more, s->free));
  }
  s->tare = ferrule_plus(s->tare, 1, ferrule_axes_over(f, s->free));
  if (still) return none;
  if (s->since < s->n.hold_time) s->since = o->time;
  if (height < s->before) return ferrule_along(-ferrule_touching(s));
  if (s->rest_force == 0)
    ferrule_hand_moved(&s->hand, s->from.x - o->displacement.x, o->time - s->since,
                       s->n.approach_speed);
  if (ferrule_time_to_centre(s, o)) {
    ferrule_cone_start(&s->cone, s->to_centre != 2, ferrule_play(&s->touches, o->height));
    return ferrule_begin(s, FERRULE_CENTRE, o);
  }
  return ferrule_along(s->known_stiffness > 0 ? -ferrule_touching_from(s, s->n.approach_speed)
                                              : -s->n.approach_speed);
}

static inline void ferrule_centred(ferrule_search* s, const ferrule_observed* o) {
  const double near = s->n.near_entrance;
  s->touches.has_cone = true;
  if (--s->to_centre > 0) return;
  s->entrance =
      ferrule_clamp(o->height - ferrule_height_of(&s->touches, s->cone.play), -near, near);
  s->before = ferrule_before * near;
  s->behind = 0;
}

// The cone is felt along the bore first, where the holder is stiff, and otherwise sideways.
static inline ferrule_axes ferrule_centre(ferrule_search* s, const ferrule_observed* o) {
  const ferrule_v2 at = o->displacement.across;
  const bool soft = ferrule_gives_way(s);
  const double force = soft ? ferrule_norm(s->smooth.across) : s->smooth.x;
  const double felt = soft ? ferrule_felt_force(s) : ferrule_felt_smooth_force(s);
  ferrule_axes v = ferrule_along(0);
  if (s->cone.until_felt) {
    const ferrule_v2 way = ferrule_difference(at, s->from.across);
    s->at_cone = s->at_cone && force > 0.5 * felt;
    if (!s->at_cone && force > felt) {
      ferrule_cone_arrived(&s->cone, at);
      s->at_cone = true;
    } else if (ferrule_norm(way) > 2 * ferrule_play(&s->touches, o->height)) {
      s->to_centre = 0;  // there is none
      return ferrule_begin(s, FERRULE_APPROACH, o);
    }
    if (s->cone.until_felt) v.across = ferrule_times(s->n.insert_speed, s->cone.to);
    return v;
  }
  if (s->smooth.x < -felt)
    s->held = ferrule_max(s->held, ferrule_norm(ferrule_difference(at, s->cone.touched)));
  if (!ferrule_is_at(s, s->cone.to, o)) {
    v.across = ferrule_sideways_to(s, s->cone.to, o);
    return v;
  }
  ferrule_cone_arrived(&s->cone, at);
  if (ferrule_cone_ended(&s->cone)) {
    ferrule_centred(s, o);
    return ferrule_begin(s, FERRULE_APPROACH, o);
  }
  return v;
}

static inline ferrule_axes ferrule_touch(ferrule_search* s, const ferrule_observed* o) {
  const double rested = o->time - s->since, x = o->displacement.x, felt = ferrule_felt_force(s);
  const double sideways = ferrule_norm(s->smooth.across);
  const bool first = s->stiffness == 0;
  // What the mean may be wrong by.
  const double error =
      first ? ferrule_force_error * felt : ferrule_height_error(s->n.fibre_radius) * s->stiffness;
  if (rested < s->hand.delay + ferrule_settling * s->n.hold_time) return ferrule_along(0);
  s->sum += o->wrench.x;
  ++s->read;
  const double f = s->sum / s->read;
  if (rested < s->hand.delay + s->n.hold_time || s->noise.x > s->read * error * error)
    return ferrule_along(0);
  if (!ferrule_late(s) && sideways > ferrule_slides * f && f > 0.5 * felt)
    return ferrule_begin(s, FERRULE_INSERT, o);
  if (first && s->rest_force == 0) {
    if (f < 0.5 * felt) return ferrule_begin(s, FERRULE_APPROACH, o);  // it was noise
    s->rest_at = x;
    s->rest_force = f;
    return ferrule_begin(s, FERRULE_RELEASE, o);
  }
  if (first && !(f < ferrule_released * s->rest_force)) return ferrule_begin(s, FERRULE_RELEASE, o);
  if (first) s->stiffness = (s->rest_force - f) / (x - s->rest_at);
  if (!first && f < 0.5 * felt) return ferrule_begin(s, FERRULE_LOWER, o);
  ferrule_axes touch = o->displacement;
  touch.x = x + f / s->stiffness;
  ferrule_rested(&s->touches, touch, o->height);
  return ferrule_begin(s, FERRULE_LIFT, o);
}

// Unlike under a growing force, nothing slides on a slope while it gives way.
static inline ferrule_axes ferrule_release(ferrule_search* s, const ferrule_observed* o) {
  if (o->wrench.x > ferrule_left * s->rest_force)
    return ferrule_along(ferrule_releasing * ferrule_touching(s));
  return ferrule_begin(s, FERRULE_TOUCH, o);
}

static inline ferrule_axes ferrule_lift(ferrule_search* s, const ferrule_observed* o) {
  const double x = o->displacement.x, held = sqrt(ferrule_square(s->smooth));
  const double high = ferrule_max(s->from.x, ferrule_highest_rest(&s->touches)) + s->n.lift;
  if (o->wrench.x < -s->n.push_force)
    return ferrule_begin(s, FERRULE_INSERT, o);  // so fast it is in the bore
  if (x >= high && held < ferrule_felt_smooth_force(s)) return ferrule_begin(s, FERRULE_MOVE, o);
  return ferrule_along(x < s->from.x + ferrule_gently * s->n.lift ? ferrule_pulling(s)
                                                                  : s->n.insert_speed);
}

static inline ferrule_axes ferrule_move(ferrule_search* s, const ferrule_observed* o) {
  const ferrule_v2 place = s->touches.next_across, tilt = s->touches.next_tilt;
  const double left = ferrule_norm(ferrule_difference(tilt, o->displacement.about));
  ferrule_axes v = ferrule_along(0);
  if (ferrule_is_at(s, place, o) && left < ferrule_tilted * s->n.tilt)
    return ferrule_begin(s, FERRULE_LOWER, o);
  v.across = ferrule_sideways_to(s, place, o);
  v.about = ferrule_tilted_to(s, tilt, ferrule_goal_time(s), o);
  return v;
}

static inline ferrule_axes ferrule_lower(ferrule_search* s, const ferrule_observed* o) {
  const double x = o->displacement.x;
  if (o->wrench.x > ferrule_felt_force(s)) return ferrule_begin(s, FERRULE_TOUCH, o);
  if (x + s->smooth.x / s->stiffness < ferrule_lowest_rest(&s->touches) - s->n.lift)
    return ferrule_begin(s, o->height < -s->n.lift ? FERRULE_INSERT : FERRULE_APPROACH, o);
  double clear = ferrule_highest_rest(&s->touches) + ferrule_clear * s->n.lift;
  if (ferrule_late(s)) clear += ferrule_further * ferrule_climb(&s->touches);
  const double braking =
      (x - clear) / ferrule_max(ferrule_brake_time, ferrule_brake_lags * s->hand.delay);
  return ferrule_along(-ferrule_clamp(braking, ferrule_touching(s), s->n.insert_speed));
}

static inline ferrule_axes ferrule_insert(ferrule_search* s, const ferrule_observed* o) {
  const double look = ferrule_max(ferrule_look_every, ferrule_look_lags * s->hand.delay);
  const double x = o->displacement.x;
  if (o->time - s->since >= look) {
    const bool held_up = s->from.x - x < ferrule_held_up * ferrule_inserting(s) * look;
    const bool shallow = s->touches.begun && o->height - s->entrance > -s->n.near_entrance &&
                         x > ferrule_lowest_rest(&s->touches) - ferrule_shallow * s->n.lift;
    ferrule_begin(s, !held_up ? FERRULE_INSERT : shallow ? FERRULE_TOUCH : FERRULE_BACK_OFF, o);
  }
  ferrule_axes push = o->wrench;
  push.x = ferrule_max(0, push.x);  // what pulls is no reason to stop
  const double pressed = ferrule_square(push) / (s->push * s->push);
  ferrule_axes v = ferrule_along(-ferrule_inserting(s) * ferrule_max(0, 1 - pressed));
  v.across = ferrule_times(s->n.yield, o->wrench.across);
  v.about =
      ferrule_tilted_to(s, s->straight, ferrule_max(ferrule_goal_time(s), ferrule_tilt_time), o);
  return v;
}

// Until nothing presses any more; no further where it is held back.
static inline ferrule_axes ferrule_back_off(ferrule_search* s, const ferrule_observed* o) {
  const bool off =
      o->displacement.x >= s->from.x + s->n.lift && s->smooth.x < ferrule_freed * s->n.push_force;
  return off || o->wrench.x < -s->n.push_force ? ferrule_begin(s, FERRULE_STRAIGHTEN, o)
                                               : ferrule_along(ferrule_pulling(s));
}

// With what it inserts once it has straightened again, where it inserted with `push` [N].
static inline double ferrule_harder(double push, double push_force) {
  return ferrule_min(ferrule_more * push, ferrule_hardest * push_force);
}

// About y and z one way and the other until the bore resists, or far enough, and to the middle,
// which `from` has then. Along the bore it gives way all the time, and turns slower where a late
// hand would let the force there grow too much.
static inline ferrule_axes ferrule_straighten(ferrule_search* s, const ferrule_observed* o) {
  const double force = fabs(o->wrench.x), felt = fabs(s->smooth.x), touching = ferrule_touching(s);
  const double pressed = ferrule_max(force, felt) / s->n.push_force;
  const double slower =
      ferrule_late(s) ? ferrule_clamp(ferrule_hardest - pressed, ferrule_least_turning, 1) : 1;
  const double rate = slower * ferrule_probing * s->n.tilt_rate * ferrule_place_time /
                      ferrule_max(ferrule_place_time, s->hand.delay);
  const bool about_y = s->probe / 3 == 0;
  const int step = s->probe % 3;
  const double way = step == 1 ? -1 : 1, middle = 0.5 * (s->resisted[0] + s->resisted[1]);
  const double at = about_y ? o->displacement.about.y : o->displacement.about.z;
  const double moment = about_y ? s->smooth.about.y : s->smooth.about.z;
  double* from = about_y ? &s->from.about.y : &s->from.about.z;
  const double past = way * (at - *from);  // before, it is held where it comes from
  const bool resists =
      past >= 0 && (way * moment < -ferrule_felt_moment(s) || force > s->n.push_force);
  const bool there =
      step == 2 ? at + s->hand.delay * rate >= middle : resists || past > ferrule_most_tilt;
  ferrule_axes v = ferrule_along(ferrule_clamp(
      o->wrench.x / (ferrule_stiffness(s) * ferrule_goal_time(s)), -touching, touching));
  s->relaxed = s->relaxed || felt < 0.5 * ferrule_felt_force(s);
  if (!s->relaxed) return v;
  if (!there) {
    *(about_y ? &v.about.y : &v.about.z) = way * rate;
    return v;
  }
  if (step == 2)
    *from = middle;
  else
    s->resisted[step] = at;
  if (++s->probe < FERRULE_PROBES) return v;
  s->straight = s->from.about;
  s->push = ferrule_harder(s->push, s->n.push_force);
  return ferrule_begin(s, FERRULE_INSERT, o);
}

static inline ferrule_axes ferrule_phase_command(ferrule_search* s, const ferrule_observed* o) {
  switch (s->phase) {
    case FERRULE_APPROACH:
      return ferrule_approach(s, o);
    case FERRULE_CENTRE:
      return ferrule_centre(s, o);
    case FERRULE_TOUCH:
      return ferrule_touch(s, o);
    case FERRULE_RELEASE:
      return ferrule_release(s, o);
    case FERRULE_LIFT:
      return ferrule_lift(s, o);
    case FERRULE_MOVE:
      return ferrule_move(s, o);
    case FERRULE_LOWER:
      return ferrule_lower(s, o);
    case FERRULE_INSERT:
      return ferrule_insert(s, o);
    case FERRULE_BACK_OFF:
      return ferrule_back_off(s, o);
    case FERRULE_STRAIGHTEN:
      break;
  }
  return ferrule_straighten(s, o);
}

// Once per period, from the start on: the velocity until the next.
static inline ferrule_axes ferrule_search_command(ferrule_search* s, ferrule_observed o) {
  o.wrench = ferrule_plus(o.wrench, -1, s->tare);
  s->smooth = ferrule_plus(s->smooth, ferrule_smoothing, ferrule_plus(o.wrench, -1, s->smooth));
  const ferrule_axes meant = ferrule_phase_command(s, &o);  // which may measure the gain
  return ferrule_axes_over(meant, s->hand.gain);
}
