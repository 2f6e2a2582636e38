// How a holder answers what it is told, measured on its way in free air at one speed: by how much it
// is late, and by how much more than that it moves.
//
// At a time T after it was told to move at the speed v it has moved by g v (T - d) along its way and
// moves at g v, its mean over at least the last half of T: a supervisor lets it go by fits and starts
// where the sensor is noisy. d is a delay or the time constant of a lag.
#pragma once

#include "controller/search/axes.h"

typedef struct {
  double time, way;  // [s, m]
} ferrule_mark;

typedef struct {
  double delay;  // d, the best guess so far [s]
  double gain;   // g [-], between 1/2 and 2; 1 until it is measured
  bool measured;
  ferrule_mark before, last;
} ferrule_hand;

// Nothing is left to measure where the delay is known [s]; 0: it is not.
static inline void ferrule_hand_start(ferrule_hand* h, double delay) {
  const ferrule_mark none = {0, 0};
  h->delay = delay;
  h->gain = 1;
  h->measured = delay > 0;
  h->before = h->last = none;
}

// It has moved that far [m], `time` after it set out at `speed` [s, m/s].
static inline void ferrule_hand_moved(ferrule_hand* h, double way, double time, double speed) {
  const double measured_time = 0.25;  // so long it is measured [s]
  const double measured_delays = 5;   // and at least so many times its delay
  const double most_gain = 2;         // or its inverse: what moves less is held back
  if (h->measured) return;
  if (time >= 2 * h->last.time) {
    h->before = h->last;
    h->last.time = time;
    h->last.way = way;
  }
  if (!(way > h->before.way && time > h->before.time)) return;
  const double reached = (way - h->before.way) / (time - h->before.time);
  h->delay = ferrule_max(0, time - way / reached);
  h->measured = time > ferrule_max(measured_time, measured_delays * h->delay);
  if (h->measured) h->gain = ferrule_clamp(reached / speed, 1 / most_gain, most_gain);
}
