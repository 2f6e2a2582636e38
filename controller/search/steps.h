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
//                the middle, with F_p larger by 15 %, and by 35 % at most; never with more than nine
//                tenths of the force limit that the trial states. A tilt moves the
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
// What a phase remembers is set where it begins, by a function of its own; a step then says how to
// move, or which phase is next. What all share is what is known of sensor, holder and opening.
//
// Forces are relative to their mean in free air. Lengths and speeds are of the hand.
#pragma once

#include "controller/search/cone_centre.h"
#include "controller/search/hand_response.h"
#include "controller/search/numbers.h"
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
  FERRULE_STRAIGHTEN,
  FERRULE_PHASES
} ferrule_phase;

typedef struct {
  ferrule_axes wrench;        // relative to that at rest at the start [N, N m]
  ferrule_axes displacement;  // since the start [m, rad]
  double height;              // before where the entrance is taken to be [m]; < 0 past it
  double time;                // since the start [s]
  double force_limit;         // a larger force at the holder ends the trial [N]; infinite: unknown
} ferrule_observed;

// What somebody knows of his own hand, and others find out.
typedef struct {
  double lag;        // from what is felt to what the holder does [s], >= 0
  double stiffness;  // of the holder along the bore [N/m], > 0
} ferrule_own_hand;

// What is known of the sensor.
typedef struct {
  ferrule_axes tare;    // mean of what was read in free air
  ferrule_axes noise;   // mean squares of what was read there
  int readings;         // there
  ferrule_axes smooth;  // of the last readings, less the tare
} ferrule_sensor;

// What is known of the holder along the bore: the first touch, which gives way, measures it.
typedef enum { FERRULE_UNTOUCHED, FERRULE_TOUCHED, FERRULE_MEASURED } ferrule_first_touch;
typedef struct {
  ferrule_first_touch first;
  double rest_at, rest_force;  // of the first touch: x of the hand [m], f [N]
  double stiffness;            // k, until it is measured as told or assumed [N/m]
  bool told;                   // how stiff it is
  bool gives_way;              // so that a push moves it by more than the end is lifted
} ferrule_holder;

// What is known of the bore's entrance, beside what touches tell.
typedef enum { FERRULE_ROUGHLY, FERRULE_FINELY, FERRULE_NO_MORE } ferrule_centring;
typedef struct {
  double height;          // where it was taken to be at 0 [m]
  double before, behind;  // up to which heights before and behind it a touch is to be expected [m]
  ferrule_centring next;  // in a cone, if there is one
  double held;            // how far from where it touched the cone held it [m]
} ferrule_entrance;

typedef struct {
  ferrule_numbers n;
  ferrule_sensor sensor;
  ferrule_hand hand;
  ferrule_holder holder;
  ferrule_touches touches;
  ferrule_entrance entrance;
  double push;          // with which it inserts [N]
  ferrule_v2 straight;  // and the tilt [rad]

  ferrule_phase phase;
  double since;       // its begin [s]
  ferrule_axes from;  // and the displacement then
  // What each phase remembers beside that, from its begin on.
  struct {
    bool rested;     // the first time, for the noise
    double set_out;  // when [s]
  } approach;
  struct {
    ferrule_cone cone;
    bool touching;  // it touches the cone still
  } centre;
  struct {
    double sum;  // of the axial force at rest [N]
    int read;    // readings of it
  } touch;
  struct {
    double time, x;  // when and where it last looked whether it is held up [s, m]
  } insert;
  struct {
    bool relaxed;        // along the bore, before it turns
    int probe;           // of six: about each axis one way, the other way, the middle
    double resisted[2];  // at which tilts [rad]
    ferrule_v2 middle;   // at first the tilt at which it began [rad]
  } straighten;
} ferrule_search;

enum { FERRULE_PROBES = 6 };  // of straightening

// `own`: null where nobody knows it.
static inline void ferrule_search_start(ferrule_search* s, const ferrule_numbers* numbers,
                                        const ferrule_own_hand* own) {
  const ferrule_touch_numbers touch = {
      numbers->fibre_radius,  numbers->bore_radius, numbers->mouth_radius, numbers->lead_in_length,
      numbers->near_entrance, numbers->tilt,        numbers->lift};
  memset(s, 0, sizeof *s);
  s->n = *numbers;
  s->holder.stiffness = numbers->push_force / (ferrule_stop_time * numbers->touch_speed);
  ferrule_hand_start(&s->hand);
  if (own) {
    ferrule_hand_known(&s->hand, own->lag);
    s->holder.told = true;
    s->holder.stiffness = own->stiffness;
    s->holder.gives_way = numbers->push_force / own->stiffness > numbers->lift;
  }
  ferrule_touches_start(&s->touches, touch);
  s->entrance.before = s->entrance.behind = numbers->near_entrance;
  s->push = numbers->push_force;
}

static inline double ferrule_felt_force(const ferrule_search* s) {
  const double above_noise =
      ferrule_max(s->n.touch_force, ferrule_noises * sqrt(s->sensor.noise.x));
  return ferrule_min(above_noise, ferrule_most_felt * s->n.push_force);
}

static inline double ferrule_felt_smooth_force(const ferrule_search* s) {
  return ferrule_max(s->n.touch_force, ferrule_smooth_noises * sqrt(s->sensor.noise.x));
}

static inline double ferrule_felt_moment(const ferrule_search* s) {
  const double noise = ferrule_max(s->sensor.noise.about.y, s->sensor.noise.about.z);
  return ferrule_max(s->n.turn_moment, ferrule_smooth_noises * sqrt(noise));
}

// A speed from which the holder, late as it is, does not go on by more than `further`.
static inline double ferrule_stoppable(const ferrule_search* s, double speed, double further) {
  return speed * s->hand.delay > further ? further / s->hand.delay : speed;
}

// At which a touch that it feels then comes to as much as it may.
static inline double ferrule_touching_from(const ferrule_search* s, double speed) {
  const double further = ferrule_stop_force * s->n.push_force - ferrule_felt_force(s);
  return ferrule_stoppable(s, speed, further / s->holder.stiffness);
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
                           (ferrule_hardest - 1) * s->n.push_force / s->holder.stiffness);
}

// A tilted end gives way in the bore, and comes to rest in parts of the lift.
static inline double ferrule_inserting(const ferrule_search* s) {
  const double soft = s->holder.first == FERRULE_MEASURED
                          ? ferrule_steady_force * s->n.push_force / s->holder.stiffness
                          : 0;
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

// With what it inserts once it has straightened again, where it inserted with `push` [N].
static inline double ferrule_harder(double push, double push_force) {
  return ferrule_min(ferrule_more * push, ferrule_hardest * push_force);
}

static inline void ferrule_read_in_free_air(ferrule_sensor* sensor, ferrule_axes f) {
  ++sensor->readings;
  if (sensor->readings > 1) {
    const ferrule_axes square = {f.x * f.x,
                                 {f.across.y * f.across.y, f.across.z * f.across.z},
                                 {f.about.y * f.about.y, f.about.z * f.about.z}};
    const ferrule_axes more = ferrule_plus(square, -1, sensor->noise);
    sensor->noise = ferrule_plus(sensor->noise, 1, ferrule_axes_over(more, sensor->readings));
  }
  sensor->tare = ferrule_plus(sensor->tare, 1, ferrule_axes_over(f, sensor->readings));
}

// The steps, once per period: each returns the phase of the next period, and changes the velocity
// until then, which is zero, where it does not stand still.

static inline void ferrule_begin_approach(ferrule_search* s, const ferrule_observed* o) {
  s->approach.rested = true;
  s->approach.set_out = o->time;
}

// The second time no lower than where the end comes off the cone before it is in the middle.
static inline bool ferrule_time_to_centre(const ferrule_search* s, const ferrule_observed* o) {
  const double length = s->n.lead_in_length;
  const bool keeps_away = ferrule_late(s) || s->holder.gives_way;
  if (!keeps_away || !s->hand.measured || s->entrance.next == FERRULE_NO_MORE) return false;
  if (s->entrance.next == FERRULE_ROUGHLY) return o->height < ferrule_centre_at * length;
  return o->height <
         ferrule_clamp(ferrule_height_of(&s->touches, ferrule_held_play * s->entrance.held),
                       ferrule_centre_above * length, ferrule_centre_below * length);
}

static inline ferrule_phase ferrule_approach(ferrule_search* s, const ferrule_observed* o,
                                             ferrule_axes* v) {
  const bool rests = !s->approach.rested && o->time < s->n.hold_time;
  const double height = o->height - s->entrance.height;
  if (!rests && o->wrench.x > ferrule_felt_force(s)) return FERRULE_TOUCH;
  if (height < -s->entrance.behind) return FERRULE_INSERT;
  ferrule_read_in_free_air(&s->sensor, o->wrench);
  if (rests) return FERRULE_APPROACH;
  if (!s->approach.rested) ferrule_begin_approach(s, o);
  if (height < s->entrance.before) {
    v->x = -ferrule_touching(s);
    return FERRULE_APPROACH;
  }
  if (s->holder.first == FERRULE_UNTOUCHED)
    ferrule_hand_moved(&s->hand, s->from.x - o->displacement.x, o->time - s->approach.set_out,
                       s->n.approach_speed);
  if (ferrule_time_to_centre(s, o)) return FERRULE_CENTRE;
  const double speed = s->n.approach_speed;
  v->x = -(s->holder.told ? ferrule_touching_from(s, speed) : speed);
  return FERRULE_APPROACH;
}

static inline void ferrule_begin_centre(ferrule_search* s, const ferrule_observed* o) {
  const bool fine = s->entrance.next == FERRULE_FINELY;
  ferrule_cone_start(&s->centre.cone, fine, ferrule_play(&s->touches, o->height));
  s->centre.touching = fine;  // from the first time
}

static inline void ferrule_centred(ferrule_search* s, const ferrule_observed* o) {
  const double near = s->n.near_entrance;
  const ferrule_cone* cone = &s->centre.cone;
  s->touches.has_cone = true;
  s->entrance.next = cone->fine ? FERRULE_NO_MORE : FERRULE_FINELY;
  if (!cone->fine) return;
  s->entrance.height =
      ferrule_clamp(o->height - ferrule_height_of(&s->touches, cone->play), -near, near);
  s->entrance.before = ferrule_before * near;
  s->entrance.behind = 0;
}

// The cone is felt along the bore first, where the holder is stiff, and otherwise sideways.
static inline ferrule_phase ferrule_centre(ferrule_search* s, const ferrule_observed* o,
                                           ferrule_axes* v) {
  ferrule_cone* cone = &s->centre.cone;
  const ferrule_v2 at = o->displacement.across;
  const bool soft = s->holder.gives_way;
  const double force = soft ? ferrule_norm(s->sensor.smooth.across) : s->sensor.smooth.x;
  const double felt = soft ? ferrule_felt_force(s) : ferrule_felt_smooth_force(s);
  if (cone->until_felt) {
    const ferrule_v2 way = ferrule_difference(at, s->from.across);
    s->centre.touching = s->centre.touching && force > ferrule_unfelt * felt;
    if (!s->centre.touching && force > felt) {
      ferrule_cone_arrived(cone, at);
      s->centre.touching = true;
    } else if (ferrule_norm(way) > ferrule_no_cone * ferrule_play(&s->touches, o->height)) {
      s->entrance.next = FERRULE_NO_MORE;
      return FERRULE_APPROACH;
    }
    if (cone->until_felt) v->across = ferrule_times(s->n.insert_speed, cone->to);
    return FERRULE_CENTRE;
  }
  if (s->sensor.smooth.x < -felt)
    s->entrance.held =
        ferrule_max(s->entrance.held, ferrule_norm(ferrule_difference(at, cone->touched)));
  if (!ferrule_is_at(s, cone->to, o)) {
    v->across = ferrule_sideways_to(s, cone->to, o);
    return FERRULE_CENTRE;
  }
  ferrule_cone_arrived(cone, at);
  if (!ferrule_cone_ended(cone)) return FERRULE_CENTRE;
  ferrule_centred(s, o);
  return FERRULE_APPROACH;
}

static inline void ferrule_begin_touch(ferrule_search* s, const ferrule_observed* o) {
  (void)o;
  s->touch.sum = 0;
  s->touch.read = 0;
}

static inline ferrule_phase ferrule_touch(ferrule_search* s, const ferrule_observed* o,
                                          ferrule_axes* v) {
  const double rested = o->time - s->since, x = o->displacement.x, felt = ferrule_felt_force(s);
  const double sideways = ferrule_norm(s->sensor.smooth.across), still = ferrule_unfelt * felt;
  const bool measured = s->holder.first == FERRULE_MEASURED;
  // What the mean may be wrong by.
  const double error = measured ? ferrule_height_error(s->n.fibre_radius) * s->holder.stiffness
                                : ferrule_force_error * felt;
  (void)v;
  if (rested < s->hand.delay + ferrule_settling * s->n.hold_time) return FERRULE_TOUCH;
  s->touch.sum += o->wrench.x;
  ++s->touch.read;
  const double f = s->touch.sum / s->touch.read;
  if (rested < s->hand.delay + s->n.hold_time || s->sensor.noise.x > s->touch.read * error * error)
    return FERRULE_TOUCH;
  if (!ferrule_late(s) && sideways > ferrule_slides * f && f > still) return FERRULE_INSERT;
  if (s->holder.first == FERRULE_UNTOUCHED) {
    if (f < still) return FERRULE_APPROACH;  // it was noise
    s->holder.first = FERRULE_TOUCHED;
    s->holder.rest_at = x;
    s->holder.rest_force = f;
    return FERRULE_RELEASE;
  }
  if (s->holder.first == FERRULE_TOUCHED) {
    if (!(f < ferrule_released * s->holder.rest_force)) return FERRULE_RELEASE;
    if (x > s->holder.rest_at)
      s->holder.stiffness = (s->holder.rest_force - f) / (x - s->holder.rest_at);
    s->holder.first = FERRULE_MEASURED;
  } else if (f < still) {
    return FERRULE_LOWER;
  }
  ferrule_axes touch = o->displacement;
  touch.x = x + f / s->holder.stiffness;
  ferrule_rested(&s->touches, touch, o->height);
  return FERRULE_LIFT;
}

// Unlike under a growing force, nothing slides on a slope while it gives way.
static inline ferrule_phase ferrule_release(ferrule_search* s, const ferrule_observed* o,
                                            ferrule_axes* v) {
  if (!(o->wrench.x > ferrule_left * s->holder.rest_force)) return FERRULE_TOUCH;
  v->x = ferrule_releasing * ferrule_touching(s);
  return FERRULE_RELEASE;
}

static inline ferrule_phase ferrule_lift(ferrule_search* s, const ferrule_observed* o,
                                         ferrule_axes* v) {
  const double x = o->displacement.x, held = sqrt(ferrule_square(s->sensor.smooth));
  const double high = ferrule_max(s->from.x, ferrule_highest_rest(&s->touches)) + s->n.lift;
  if (o->wrench.x < -s->n.push_force) return FERRULE_INSERT;  // so fast it is in the bore
  if (x >= high && held < ferrule_felt_smooth_force(s)) return FERRULE_MOVE;
  v->x = x < s->from.x + ferrule_gently * s->n.lift ? ferrule_pulling(s) : s->n.insert_speed;
  return FERRULE_LIFT;
}

static inline ferrule_phase ferrule_move(ferrule_search* s, const ferrule_observed* o,
                                         ferrule_axes* v) {
  const ferrule_v2 place = s->touches.next_across, tilt = s->touches.next_tilt;
  const double left = ferrule_norm(ferrule_difference(tilt, o->displacement.about));
  if (ferrule_is_at(s, place, o) && left < ferrule_tilted * s->n.tilt) return FERRULE_LOWER;
  v->across = ferrule_sideways_to(s, place, o);
  v->about = ferrule_tilted_to(s, tilt, ferrule_goal_time(s), o);
  return FERRULE_MOVE;
}

static inline ferrule_phase ferrule_lower(ferrule_search* s, const ferrule_observed* o,
                                          ferrule_axes* v) {
  const double x = o->displacement.x, end = x + s->sensor.smooth.x / s->holder.stiffness;
  if (o->wrench.x > ferrule_felt_force(s)) return FERRULE_TOUCH;
  if (end < ferrule_lowest_rest(&s->touches) - s->n.lift)
    return o->height < -s->n.lift ? FERRULE_INSERT : FERRULE_APPROACH;
  double clear = ferrule_highest_rest(&s->touches) + ferrule_clear * s->n.lift;
  if (ferrule_late(s)) clear += ferrule_further * ferrule_climb(&s->touches);
  const double braking =
      (x - clear) / ferrule_max(ferrule_brake_time, ferrule_brake_lags * s->hand.delay);
  v->x = -ferrule_clamp(braking, ferrule_touching(s), s->n.insert_speed);
  return FERRULE_LOWER;
}

static inline void ferrule_begin_insert(ferrule_search* s, const ferrule_observed* o) {
  ferrule_straightened(&s->touches);
  s->insert.time = o->time;
  s->insert.x = o->displacement.x;
}

// What to do next where it is held up, which it looks for from time to time.
static inline ferrule_phase ferrule_held_up(ferrule_search* s, const ferrule_observed* o) {
  const double look = ferrule_max(ferrule_look_time, ferrule_look_lags * s->hand.delay);
  const double x = o->displacement.x;
  if (o->time - s->insert.time < look) return FERRULE_INSERT;
  const bool held_up = s->insert.x - x < ferrule_slow * ferrule_inserting(s) * look;
  const bool shallow = s->touches.begun && o->height - s->entrance.height > -s->n.near_entrance &&
                       x > ferrule_lowest_rest(&s->touches) - ferrule_shallow * s->n.lift;
  s->insert.time = o->time;
  s->insert.x = x;
  return !held_up ? FERRULE_INSERT : shallow ? FERRULE_TOUCH : FERRULE_BACK_OFF;
}

static inline ferrule_phase ferrule_insert(ferrule_search* s, const ferrule_observed* o,
                                           ferrule_axes* v) {
  ferrule_axes push = o->wrench;
  push.x = ferrule_max(0, push.x);  // what pulls is no reason to stop
  const double most = ferrule_min(s->push, ferrule_of_limit * o->force_limit);
  const double pressed = ferrule_square(push) / (most * most);
  v->x = -ferrule_inserting(s) * ferrule_max(0, 1 - pressed);
  v->across = ferrule_times(s->n.yield, o->wrench.across);
  v->about =
      ferrule_tilted_to(s, s->straight, ferrule_max(ferrule_goal_time(s), ferrule_tilt_time), o);
  return ferrule_held_up(s, o);
}

// Until nothing presses any more; no further where it is held back.
static inline ferrule_phase ferrule_back_off(ferrule_search* s, const ferrule_observed* o,
                                             ferrule_axes* v) {
  const bool off = o->displacement.x >= s->from.x + s->n.lift &&
                   s->sensor.smooth.x < ferrule_freed * s->n.push_force;
  if (off || o->wrench.x < -s->n.push_force) return FERRULE_STRAIGHTEN;
  v->x = ferrule_pulling(s);
  return FERRULE_BACK_OFF;
}

static inline void ferrule_begin_straighten(ferrule_search* s, const ferrule_observed* o) {
  s->straighten.relaxed = false;
  s->straighten.probe = 0;
  s->straighten.middle = o->displacement.about;
}

// About y and z one way and the other until the bore resists, or far enough, and to the middle.
// Along the bore it gives way all the time, and turns slower where a late hand would let the force
// there grow too much.
static inline ferrule_phase ferrule_straighten(ferrule_search* s, const ferrule_observed* o,
                                               ferrule_axes* v) {
  const ferrule_axes smooth = s->sensor.smooth;
  const double force = fabs(o->wrench.x), felt = fabs(smooth.x), touching = ferrule_touching(s);
  const double pressed = ferrule_max(force, felt) / s->n.push_force;
  const double most =
      ferrule_min(ferrule_hardest, ferrule_of_limit * o->force_limit / s->n.push_force);
  const double slower =
      ferrule_late(s) ? ferrule_clamp(most - pressed, ferrule_least_turning, 1) : 1;
  const double rate = slower * ferrule_turning * s->n.tilt_rate * ferrule_place_time /
                      ferrule_max(ferrule_place_time, s->hand.delay);
  const bool about_y = s->straighten.probe / 3 == 0;
  const int step = s->straighten.probe % 3;
  double* resisted = s->straighten.resisted;
  double* from = about_y ? &s->straighten.middle.y : &s->straighten.middle.z;
  const double way = step == 1 ? -1 : 1, middle = 0.5 * (resisted[0] + resisted[1]);
  const double at = about_y ? o->displacement.about.y : o->displacement.about.z;
  const double moment = about_y ? smooth.about.y : smooth.about.z;
  const double past = way * (at - *from);  // before, it is held where it comes from
  const bool resists =
      past >= 0 && (way * moment < -ferrule_felt_moment(s) || force > s->n.push_force);
  const bool there =
      step == 2 ? at + s->hand.delay * rate >= middle : resists || past > ferrule_most_tilt;
  v->x = ferrule_clamp(o->wrench.x / (s->holder.stiffness * ferrule_goal_time(s)), -touching,
                       touching);
  s->straighten.relaxed = s->straighten.relaxed || felt < ferrule_unfelt * ferrule_felt_force(s);
  if (!s->straighten.relaxed) return FERRULE_STRAIGHTEN;
  if (!there) {
    *(about_y ? &v->about.y : &v->about.z) = way * rate;
    return FERRULE_STRAIGHTEN;
  }
  if (step == 2)
    *from = middle;
  else
    resisted[step] = at;
  if (++s->straighten.probe < FERRULE_PROBES) return FERRULE_STRAIGHTEN;
  s->straight = s->straighten.middle;
  s->push = ferrule_harder(s->push, s->n.push_force);
  v->x = 0;
  return FERRULE_INSERT;
}

// In the order of ferrule_phase. What begins a phase sets what it remembers, if anything.
typedef struct {
  const char* name;
  void (*begin)(ferrule_search* s, const ferrule_observed* o);
  ferrule_phase (*step)(ferrule_search* s, const ferrule_observed* o, ferrule_axes* v);
} ferrule_phase_steps;

static const ferrule_phase_steps ferrule_phases[FERRULE_PHASES] = {
    {"approach", ferrule_begin_approach, ferrule_approach},
    {"centre", ferrule_begin_centre, ferrule_centre},
    {"touch", ferrule_begin_touch, ferrule_touch},
    {"release", NULL, ferrule_release},
    {"lift", NULL, ferrule_lift},
    {"move", NULL, ferrule_move},
    {"lower", NULL, ferrule_lower},
    {"insert", ferrule_begin_insert, ferrule_insert},
    {"back_off", NULL, ferrule_back_off},
    {"straighten", ferrule_begin_straighten, ferrule_straighten}};

// Once per period, from the start on: the velocity until the next.
static inline ferrule_axes ferrule_search_command(ferrule_search* s, ferrule_observed o) {
  ferrule_axes v = {0, {0, 0}, {0, 0}};
  ferrule_sensor* sensor = &s->sensor;
  o.wrench = ferrule_plus(o.wrench, -1, sensor->tare);
  sensor->smooth =
      ferrule_plus(sensor->smooth, ferrule_smoothing, ferrule_plus(o.wrench, -1, sensor->smooth));
  const ferrule_phase next = ferrule_phases[s->phase].step(s, &o, &v);  // may measure the gain
  if (next != s->phase) {
    s->phase = next;
    s->since = o.time;
    s->from = o.displacement;
    if (ferrule_phases[next].begin) ferrule_phases[next].begin(s, &o);
  }
  return ferrule_axes_over(v, s->hand.gain);
}
