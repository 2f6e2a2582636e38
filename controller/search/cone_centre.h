// Where a fibre's end moves sideways to find the axis of a cone that it is in, without touching it
// from above: the cone of a lead-in resists where the end reaches it.
//
// Upright and at one height the end can be off the axis by the play p, from there on it touches the
// cone. Twice:
//   roughly   along y and then along z until it touches. Both places are on the circle of radius p
//             about the axis, which is to the left of the way between them, as the corner of the
//             end's way is. p is taken from where the cone is believed to be.
//   finely    near the axis, lower: both ways along y, the middle of which is the axis there, and
//             half of which is p; one way along z, and back by p.
//
// All in one world, the hand's or the tip's. Places are of the hand [m].
#pragma once

#include "controller/search/axes.h"

typedef struct {
  bool fine;
  double play;  // p [m]
  int step;
  ferrule_v2 first, touched;  // where it touched first, and last [m]
  // What to do next: move in the direction `to` until it is felt; or to the place `to` [m].
  bool until_felt;
  ferrule_v2 to;
} ferrule_cone;

// With the play p > 0 taken to be this [m]; finely it is measured.
static inline void ferrule_cone_start(ferrule_cone* c, bool fine, double play) {
  const ferrule_v2 nowhere = {0, 0}, y = {1, 0};
  c->fine = fine;
  c->play = play;
  c->step = 0;
  c->first = c->touched = nowhere;
  c->until_felt = true;
  c->to = y;
}

static inline int ferrule_cone_last(const ferrule_cone* c) {
  return c->fine ? 5 : 4;
}
static inline bool ferrule_cone_ended(const ferrule_cone* c) {
  return c->step == ferrule_cone_last(c);
}

// Centre of the circle of that radius through two places, to the left of who goes from the first to
// the second; midway where they are further apart than its diameter.
static inline ferrule_v2 ferrule_centre_of_circle(ferrule_v2 first, ferrule_v2 second,
                                                  double radius) {
  const ferrule_v2 apart = ferrule_difference(second, first);
  const ferrule_v2 middle = ferrule_sum(first, ferrule_times(0.5, apart));
  const double far = ferrule_norm(apart), square = ferrule_dot(apart, apart);
  const double off = sqrt(ferrule_max(0, radius * radius - 0.25 * square));
  if (!(far > 0)) return middle;
  return ferrule_sum(middle, ferrule_times(off, ferrule_over(ferrule_turned(apart), far)));
}

// It touched, or is there, at this place.
static inline void ferrule_cone_arrived(ferrule_cone* c, ferrule_v2 place) {
  const ferrule_v2 back_y = {-1, 0}, z = {0, 1}, by_y = {c->play, 0};
  if (c->until_felt) c->touched = place;
  if (++c->step == 1) {
    c->first = place;
    c->until_felt = c->fine;
    c->to = c->fine ? back_y : ferrule_difference(place, by_y);
  } else if (c->fine && c->step == 2) {
    c->play = 0.5 * ferrule_norm(ferrule_difference(c->first, place));
    c->until_felt = false;
    c->to = ferrule_times(0.5, ferrule_sum(c->first, place));
  } else if (c->step == ferrule_cone_last(c) - 2) {
    c->until_felt = true;
    c->to = z;
  } else if (c->step == ferrule_cone_last(c) - 1) {
    c->until_felt = false;
    c->to = c->fine ? ferrule_difference(place, ferrule_times(c->play, z))
                    : ferrule_centre_of_circle(c->first, place, c->play);
  }
}
