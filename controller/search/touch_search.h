// Where a fibre's end touches next, while it looks for the bore.
//
// It comes down upright. If it comes to rest, it touches there again, tilted to several sides:
//   on the front face   8 sides the first time and 4 afterwards. All touches together locate the
//                       opening and its clearance (controller/search/locate_opening.h). Where the
//                       end's own slope turned out to be a good part of the tilt, so that it rests
//                       on one side however it is tilted, 4 more sides about that slope, further
//                       apart.
//   on an edge          the cone of a lead-in, or the bore's edge where the end is in it already.
//                       There 3 sides tell which one is caught: the one that a tilt lifts. It goes
//                       the other way, by what an end that touches the opening's edge at this
//                       height is off its axis; by half of the last step where it had come from
//                       there.
// Then it comes down upright at the axis. It is on an edge where the ferrule has turned out to have
// a cone, by the height of a touch or by how much lower than another it came; or where the end
// rests lower than the face lets it; or where no opening explains the touches, but only twice in a
// row.
//
// A rounded rim rests on the face with a smaller disc, as if the clearance were larger.
//
// All in one world, the hand's or the tip's. x, across and tilts are of the hand since the start.
#pragma once

#include "controller/search/locate_opening.h"
#include "controller/search/numbers.h"

typedef struct {
  double fibre_radius;    // r [m]
  double bore_radius;     // R [m], > r
  double mouth_radius;    // of the lead-in at the front face [m], >= R
  double lead_in_length;  // [m]; 0: none
  double near;            // up to which the entrance's place may be wrong [m], >= 0
  double tilt;            // theta [rad]
  double lift;            // what counts as another height [m]
} ferrule_touch_numbers;

enum { FERRULE_MOST_TOUCHES = 64 };  // that it remembers: of the last places

typedef struct {
  ferrule_touch_numbers n;
  ferrule_axes touches[FERRULE_MOST_TOUCHES];  // the hand's displacement, and its tilts
  int count;
  ferrule_opening opening;
  ferrule_v2 next_across, next_tilt;  // the next place [m, rad]; at first the start
  bool begun, located;
  double height;   // of the last upright touch [m]
  double rested;   // x of the last touch [m]
  double highest;  // and of the highest [m]

  int first;        // the upright one of the touches here
  int side, sides;  // the next one; 0 of 0: upright
  ferrule_v2 here, centre;
  double apart;  // of the sides from their centre [rad]

  bool has_cone, on_edge, unexplained;
  int edges;          // in a row
  double edge;        // x of the last upright touch on one [m]
  double step;        // the last away from one [m]
  ferrule_v2 caught;  // and where it had been
} ferrule_touches;

static inline void ferrule_touches_start(ferrule_touches* t, ferrule_touch_numbers numbers) {
  memset(t, 0, sizeof *t);
  t->n = numbers;
}

static inline bool ferrule_upright(const ferrule_touches* t) {
  return t->sides == 0;
}
static inline double ferrule_level(const ferrule_touches* t) {
  return t->on_edge ? t->edge : t->opening.face;
}
static inline double ferrule_reach(const ferrule_touches* t) {
  return t->n.fibre_radius * ferrule_norm(ferrule_sum(t->opening.slope, t->next_tilt));
}
// Between which x it would rest at the next place, on the face or on the edge that it is on [m].
static inline double ferrule_highest_rest(const ferrule_touches* t) {
  return ferrule_level(t) + ferrule_reach(t);
}
static inline double ferrule_lowest_rest(const ferrule_touches* t) {
  return ferrule_level(t) - ferrule_reach(t);
}

// By how much an upright end can be off the axis at a height within the lead-in, or at its ends
// beyond them, and the height at which that is so [m].
static inline double ferrule_play(const ferrule_touches* t, double height) {
  const double length = t->n.lead_in_length;
  const double widened = length > 0 ? ferrule_clamp(height / length, 0, 1) : 0;
  return t->n.bore_radius - t->n.fibre_radius + widened * (t->n.mouth_radius - t->n.bore_radius);
}
static inline double ferrule_height_of(const ferrule_touches* t, double play) {
  const double clearance = t->n.bore_radius - t->n.fibre_radius;
  const double widened = (play - clearance) / (t->n.mouth_radius - t->n.bore_radius);
  return t->n.lead_in_length > 0 ? widened * t->n.lead_in_length : 0;
}
// How much higher still, should it be further away from the axis of a cone there [m].
static inline double ferrule_climb(const ferrule_touches* t) {
  if (!(t->has_cone && t->on_edge && ferrule_upright(t))) return 0;
  return t->step * t->n.lead_in_length / (t->n.mouth_radius - t->n.bore_radius);
}

// Of a touch: standard deviation of its height [m].
static inline double ferrule_height_error(double fibre_radius) {
  return ferrule_height_noise * fibre_radius;
}

// Whether it rests on an edge or on the face, and which of the earlier touches are still of use.
static inline void ferrule_recognise(ferrule_touches* t, double x, double height) {
  const double face = t->n.lead_in_length - t->n.near;  // as low as one may be
  const bool deep = x < t->highest - ferrule_reach(t) - ferrule_in_cone * t->n.lift;
  const bool below =
      t->located && x < t->opening.face - ferrule_reach(t) - ferrule_on_edge * t->n.lift;
  t->height = height;
  t->has_cone = t->has_cone || deep || (height > t->n.near && height < face);
  t->edge = x;
  t->on_edge = t->has_cone ? height < face : (below || t->unexplained) && t->edges < ferrule_edges;
  t->edges = t->on_edge ? t->edges + 1 : 0;
  t->unexplained = false;
  if ((below && !t->on_edge) || fabs(x - t->rested) > t->n.lift) t->count = 0;
  t->first = t->count;
}

static inline void ferrule_locate(ferrule_touches* t) {
  const double r = t->n.fibre_radius;
  // Near the entrance it is the face of a bore without a cone.
  const bool mouth = t->has_cone || t->height > t->n.near;
  const double off = mouth ? ferrule_play(t, t->height) : t->n.bore_radius - r;
  const ferrule_discs discs = {r, r + off};
  const ferrule_touch_errors errors = {ferrule_height_error(r), r, ferrule_slope_noise,
                                       mouth ? ferrule_mouth_noise : ferrule_bore_noise};
  t->opening = ferrule_locate_opening(t->touches, t->count, discs, errors);
  t->located = true;
  // What rests is not within the opening.
  const ferrule_v2 e = ferrule_difference(t->touches[t->count - 1].across, t->opening.axis);
  const double far = ferrule_norm(e);
  if (far < t->opening.clearance && far > 0)
    t->opening.axis = ferrule_difference(t->touches[t->count - 1].across,
                                         ferrule_times(t->opening.clearance / far, e));
}

static inline void ferrule_leave_edge(ferrule_touches* t) {
  const double off_axis = ferrule_play(t, t->height);
  ferrule_v2 caught = {0, 0};
  for (int k = t->first + 1; k < t->count; ++k)
    caught = ferrule_sum(
        caught, ferrule_times(t->touches[k].x - t->touches[t->first].x, t->touches[k].about));
  t->count = t->first;
  const double size = ferrule_norm(caught);
  if (!(size > 0)) return;
  caught = ferrule_over(caught, size);
  if (t->edges == 1 || !(t->step < off_axis)) t->step = off_axis;
  if (t->edges > 1 && ferrule_dot(caught, t->caught) < 0) t->step *= 0.5;
  t->caught = caught;
  t->here = ferrule_difference(t->here, ferrule_times(t->step, caught));
}

static inline void ferrule_first_sides(ferrule_touches* t) {
  const ferrule_v2 upright = {0, 0};
  t->here = t->touches[t->count - 1].across;
  t->apart = t->n.tilt;
  t->side = 0;
  t->sides = t->on_edge ? 3 : t->count > 1 ? 4 : 8;
  if (!t->on_edge && t->count > 1) ferrule_locate(t);
  t->centre = t->on_edge ? upright : ferrule_times(-1, t->opening.slope);
}

static inline void ferrule_further_sides(ferrule_touches* t) {
  const ferrule_opening none = {{0, 0}, {0, 0}, t->edge, 0, 0};
  t->side = t->sides = 0;
  if (t->on_edge) {
    ferrule_leave_edge(t);
    return;
  }
  ferrule_locate(t);
  if (t->opening.misfit > ferrule_misfit * ferrule_height_error(t->n.fibre_radius) ||
      ferrule_norm(t->opening.slope) > ferrule_steepest) {
    t->unexplained = true;
    t->located = false;
    t->count = 0;
    t->opening = none;
  } else if (ferrule_norm(ferrule_sum(t->opening.slope, t->centre)) > ferrule_one_side * t->apart) {
    t->centre = ferrule_times(-1, t->opening.slope);
    t->apart = ferrule_min(2 * t->apart, ferrule_furthest_apart * t->n.tilt);
    t->sides = 4;
  } else {
    t->here = t->opening.axis;
  }
}

// The k-th of so many sides: 3, 4 or 8.
static inline ferrule_v2 ferrule_side(int k, int sides) {
  const double half_root_3 = 0.8660254037844386;
  const ferrule_v2 thirds[] = {{1, 0}, {-0.5, half_root_3}, {-0.5, -half_root_3}};
  return sides == 3 ? thirds[k] : ferrule_eighth(8 / sides * k);
}

// The end has come to rest; `height` of the hand before where the entrance is taken to be [m],
// < 0 past it.
static inline void ferrule_rested(ferrule_touches* t, ferrule_axes touch, double height) {
  const ferrule_v2 upright = {0, 0};
  const bool was_upright = ferrule_upright(t);
  t->highest = t->begun ? ferrule_max(t->highest, touch.x) : touch.x;
  if (was_upright) ferrule_recognise(t, touch.x, height);
  t->begun = true;
  t->rested = touch.x;
  if (t->count == FERRULE_MOST_TOUCHES) {  // forgets the oldest
    for (int k = 1; k < t->count; ++k) t->touches[k - 1] = t->touches[k];
    --t->count;
    --t->first;
  }
  t->touches[t->count++] = touch;
  if (!t->located) t->opening.face = t->touches[0].x;
  if (was_upright)
    ferrule_first_sides(t);
  else if (t->side == t->sides)
    ferrule_further_sides(t);
  t->next_across = t->here;
  t->next_tilt = upright;
  if (ferrule_upright(t)) return;
  t->next_tilt = ferrule_sum(t->centre, ferrule_times(t->apart, ferrule_side(t->side++, t->sides)));
}
// It is upright again, without having come to rest.
static inline void ferrule_straightened(ferrule_touches* t) {
  t->sides = 0;
}
