// Where the bore opens, by touch: from the heights at which a fibre's end, tilted this way and
// that, comes to rest on the ferrule's front face.
//
// The end's disc, of radius r, rests on the crescent outside the opening, of radius R
// (sim/geometry/face_support.hpp). With the hand displaced by x along the axis, by u sideways, and
// tilted by t, it rests where
//   x = x_f + h(s + t; u - a),   h(s; e) = max of p.s over the crescent's convex hull at offset e,
// with x_f the height of the face, s the slope of the untilted end against it, and a the opening's
// axis. These five numbers and the clearance c = R - r, of which c_0 is the nominal one, minimise
//   sum over the touches of ((x - x_f - h)/sigma)^2
//     + |a|^2/a_0^2 + |s|^2/s_0^2 + (q/v_0)^2,   q = (c/c_0 - c_0/c)/2,
// q being log(c/c_0) near c_0. The point of the opening's edge that carries the end moves with R as
// with a shift of a along its radius: dh/dR = dh/da.(p + u - a)/R. A disc that touches the opening's
// edge from inside, at e = R - r, is the limit in which the crescent is a point:
// h = (s + t).r e/|e|.
//
// By Gauss and Newton's steps, damped as Marquardt did (An algorithm for least-squares estimation
// of nonlinear parameters, 1963), from several first guesses of a.
//
// All in one world, the hand's or the tip's.
#pragma once

#include "controller/search/axes.h"

typedef struct {
  double fibre, opening;  // r, and R by its nominal size [m]; 0 < r < R
} ferrule_discs;

typedef struct {
  double height;     // sigma, standard deviation of x [m], > 0
  double far;        // a_0 [m], > 0
  double slope;      // s_0 [rad], > 0
  double clearance;  // v_0 [-], > 0
} ferrule_touch_errors;

typedef struct {
  ferrule_v2 axis;   // a [m]
  ferrule_v2 slope;  // s [rad]
  double face;       // x_f [m]
  double misfit;     // root mean square of x - x_f - h [m], >= 0
  double clearance;  // c [m], > 0
} ferrule_opening;

typedef struct {
  double ahead;      // h [m]
  ferrule_v2 point;  // p = dh/ds, from the end's centre [m]
  ferrule_v2 by_e;   // dh/de [-]
} ferrule_rest;

// At a slope [rad] and an offset e of the disc's centre from the opening's [m]. A disc that lies
// within the opening counts as one that touches its edge on that side.
static inline ferrule_rest ferrule_rests(ferrule_discs discs, ferrule_v2 slope, ferrule_v2 e) {
  const double r = discs.fibre, R = discs.opening, inside = (1 + 1e-6) * (R - r);
  const ferrule_v2 nowhere = {0, 0}, y = {1, 0};
  const double off = ferrule_norm(e), steep = ferrule_norm(slope);
  const ferrule_v2 n = off > 0 ? ferrule_over(e, off) : y, across = ferrule_turned(n);
  const double far = ferrule_max(off, inside);
  // p.n of the points where the circles meet, and half the way between them.
  const double least = far < r + R ? (R * R - r * r - far * far) / (2 * far) : -r;
  const double half = sqrt(ferrule_max(0, r * r - least * least));
  const double out = ferrule_dot(slope, n), aside = ferrule_dot(slope, across);
  ferrule_rest rest = {0, nowhere, nowhere};
  if (r * out >= least * steep) {  // on the rim
    rest.point = ferrule_times(r, steep > 0 ? ferrule_over(slope, steep) : n);
    rest.ahead = r * steep;
  } else {
    const double side = aside < 0 ? -half : half, least_by_far = -least / far - 1;
    const double side_by_far = half > 0 ? -least / side * least_by_far : 0;
    const double by_far = least_by_far * out + side_by_far * aside;
    const double by_angle = least * aside - side * out;
    rest.point = ferrule_sum(ferrule_times(least, n), ferrule_times(side, across));
    rest.ahead = least * out + side * aside;
    rest.by_e = ferrule_sum(ferrule_times(by_far, n), ferrule_times(by_angle / far, across));
  }
  return rest;
}

// Unknowns: x_f, a, s, q.
enum { FERRULE_UNKNOWNS = 6 };

// The sum, that of the touches alone, half of its gradient, and Gauss and Newton's half of its
// second derivative, on and below the diagonal.
typedef struct {
  double sum, of_touches, gradient[FERRULE_UNKNOWNS], bend[FERRULE_UNKNOWNS][FERRULE_UNKNOWNS];
} ferrule_squares;

static inline double ferrule_clearance(ferrule_discs discs, double q) {
  return (discs.opening - discs.fibre) * (q + sqrt(1 + q * q));
}

static inline ferrule_squares ferrule_squares_at(const double at[FERRULE_UNKNOWNS],
                                                 const ferrule_axes* touches, int count,
                                                 ferrule_discs discs, ferrule_touch_errors errors) {
  const ferrule_v2 axis = {at[1], at[2]}, slope = {at[3], at[4]};
  const double clearance = ferrule_clearance(discs, at[5]);
  const double clearance_by_q = clearance / sqrt(1 + at[5] * at[5]);
  const double prior[FERRULE_UNKNOWNS] = {
      0, 1 / errors.far, 1 / errors.far, 1 / errors.slope, 1 / errors.slope, 1 / errors.clearance};
  const ferrule_discs now = {discs.fibre, discs.fibre + clearance};
  ferrule_squares squares;
  squares.of_touches = 0;
  for (int i = 0; i < FERRULE_UNKNOWNS; ++i) {
    squares.gradient[i] = prior[i] * prior[i] * at[i];
    for (int j = 0; j < i; ++j) squares.bend[i][j] = 0;
    squares.bend[i][i] = prior[i] * prior[i];
  }
  for (int k = 0; k < count; ++k) {
    const ferrule_v2 e = ferrule_difference(touches[k].across, axis);
    const ferrule_rest rest = ferrule_rests(now, ferrule_sum(slope, touches[k].about), e);
    const double residual = (touches[k].x - at[0] - rest.ahead) / errors.height;
    // A wider opening is one that lies further from the point on its edge.
    const double by_q =
        ferrule_dot(rest.by_e, ferrule_sum(rest.point, e)) / now.opening * clearance_by_q;
    const double by[FERRULE_UNKNOWNS] = {-1 / errors.height,
                                         rest.by_e.y / errors.height,
                                         rest.by_e.z / errors.height,
                                         -rest.point.y / errors.height,
                                         -rest.point.z / errors.height,
                                         by_q / errors.height};
    squares.of_touches += residual * residual;
    for (int i = 0; i < FERRULE_UNKNOWNS; ++i) {
      squares.gradient[i] += by[i] * residual;
      for (int j = 0; j <= i; ++j) squares.bend[i][j] += by[i] * by[j];
    }
  }
  squares.sum = squares.of_touches;
  for (int i = 0; i < FERRULE_UNKNOWNS; ++i) squares.sum += prior[i] * at[i] * prior[i] * at[i];
  return squares;
}

// By Cholesky: (bend + damping diag bend) step = -gradient.
static inline void ferrule_step(const ferrule_squares* squares, double damping,
                                double step[FERRULE_UNKNOWNS]) {
  double l[FERRULE_UNKNOWNS][FERRULE_UNKNOWNS];
  for (int i = 0; i < FERRULE_UNKNOWNS; ++i) {
    step[i] = -squares->gradient[i];
    for (int j = 0; j <= i; ++j) {
      double rest = squares->bend[i][j];
      if (i == j) rest += damping * rest;
      for (int k = 0; k < j; ++k) rest -= l[i][k] * l[j][k];
      l[i][j] = i == j ? sqrt(rest) : rest / l[j][j];
    }
    for (int k = 0; k < i; ++k) step[i] -= l[i][k] * step[k];
    step[i] /= l[i][i];
  }
  for (int i = FERRULE_UNKNOWNS - 1; i >= 0; --i) {
    for (int k = i + 1; k < FERRULE_UNKNOWNS; ++k) step[i] -= l[k][i] * step[k];
    step[i] /= l[i][i];
  }
}

// The eight directions, from y to z.
static inline ferrule_v2 ferrule_eighth(int k) {
  const double d = 0.70710678118654757;
  const ferrule_v2 v[] = {{1, 0}, {d, d}, {0, 1}, {-d, d}, {-1, 0}, {-d, -d}, {0, -1}, {d, -d}};
  return v[k];
}

// From one touch at least; five and more determine all of it but c, for which it takes touches at
// several places. A touch: where the hand is when the end rests.
static inline ferrule_opening ferrule_locate_opening(const ferrule_axes* touches, int count,
                                                     ferrule_discs discs,
                                                     ferrule_touch_errors errors) {
  // First guesses of the axis, about the last touch.
  const double distances[] = {0.05, 0.3, 1.0, 1.7};  // of r
  const int evaluations = 40;                        // from each
  const ferrule_v2 nowhere = {0, 0};
  ferrule_opening opening = {nowhere, nowhere, 0, 0, 0};
  double best = INFINITY;
  for (int guess = 0; guess < 32; ++guess) {
    const ferrule_v2 aside =
        ferrule_times(distances[guess / 8] * discs.fibre, ferrule_eighth(guess % 8));
    const ferrule_v2 axis = ferrule_sum(touches[count - 1].across, aside);
    double at[FERRULE_UNKNOWNS] = {0, axis.y, axis.z, 0, 0, 0};
    // The face where the touches on average have it.
    for (int k = 0; k < count; ++k)
      at[0] += (touches[k].x -
                ferrule_rests(discs, touches[k].about, ferrule_difference(touches[k].across, axis))
                    .ahead) /
               count;
    ferrule_squares squares = ferrule_squares_at(at, touches, count, discs, errors);
    double damping = 1e-3;
    for (int n = 1; n < evaluations; ++n) {
      double step[FERRULE_UNKNOWNS], there[FERRULE_UNKNOWNS];
      ferrule_step(&squares, damping, step);
      for (int i = 0; i < FERRULE_UNKNOWNS; ++i) there[i] = at[i] + step[i];
      const ferrule_squares tried = ferrule_squares_at(there, touches, count, discs, errors);
      const double gained = squares.sum - tried.sum;
      damping *= gained > 0 ? 0.1 : 10;
      if (!(gained > 0)) continue;
      for (int i = 0; i < FERRULE_UNKNOWNS; ++i) at[i] = there[i];
      squares = tried;
      if (gained < 1e-8 * squares.sum) break;
    }
    if (!(squares.sum < best)) continue;
    best = squares.sum;
    opening.axis.y = at[1];
    opening.axis.z = at[2];
    opening.slope.y = at[3];
    opening.slope.z = at[4];
    opening.face = at[0];
    opening.misfit = errors.height * sqrt(squares.of_touches / count);
    opening.clearance = ferrule_clearance(discs, at[5]);
  }
  return opening;
}
