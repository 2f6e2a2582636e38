// How a holder answers what it is told, measured on its way in free air at one speed: by how much it
// is late, and by how much more than that it moves.
//
// At a time T after it was told to move at the speed v it has moved by g v (T - d) along its way and
// moves at g v, its mean over at least the last half of T: a supervisor lets it go by fits and starts
// where the sensor is noisy. d is a delay or the time constant of a lag.
#pragma once

#include "controller/search/axes.h"
#include "controller/search/numbers.h"

typedef struct {
  double time, way;  // [s, m]
} ferrule_mark;

typedef struct {
  double delay;  // d, the best guess so far [s]
  double gain;   // g [-], between 1/2 and 2; 1 until it is measured
  bool measured;
  ferrule_mark before, last;
} ferrule_hand;

static inline void ferrule_hand_start(ferrule_hand* h) {
  const ferrule_hand unknown = {0, 1, false, {0, 0}, {0, 0}};
  *h = unknown;
}

// Of which somebody knows the delay [s], >= 0: nothing is left to measure.
static inline void ferrule_hand_known(ferrule_hand* h, double delay) {
  ferrule_hand_start(h);
  h->delay = delay;
  h->measured = true;
}

// It has moved that far [m], `time` after it set out at `speed` [s, m/s].
static inline void ferrule_hand_moved(ferrule_hand* h, double way, double time, double speed) {
  if (h->measured) return;
  if (time >= 2 * h->last.time) {
    h->before = h->last;
    h->last.time = time;
    h->last.way = way;
  }
  if (!(way > h->before.way && time > h->before.time)) return;
  const double reached = (way - h->before.way) / (time - h->before.time);
  h->delay = ferrule_max(0, time - way / reached);
  h->measured = time > ferrule_max(ferrule_measured_time, ferrule_measured_delays * h->delay);
  if (h->measured)
    h->gain = ferrule_clamp(reached / speed, 1 / ferrule_most_gain, ferrule_most_gain);
}
