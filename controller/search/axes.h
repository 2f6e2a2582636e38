// What the search by touch computes with. The files of controller/search are C99 and C++ at once:
// the program runs them (controller/search_law.hpp), and `ferrule export` writes them out as one C
// header (controller/c_header.hpp). Sums, products, quotients and square roots of doubles in a fixed
// order: by IEEE 754 the same bits everywhere, where the compiler contracts nothing
// (-ffp-contract=off). Nothing allocates.
#pragma once

#include <math.h>
#include <stdbool.h>
#include <string.h>

// Across the bore, along y and z; or about y and z.
typedef struct {
  double y, z;
} ferrule_v2;

// A wrench [N, N m], a displacement [m, rad] or a velocity [m/s, rad/s]: along the bore, across it,
// and about the axes across.
typedef struct {
  double x;
  ferrule_v2 across, about;
} ferrule_axes;

static inline ferrule_v2 ferrule_sum(ferrule_v2 a, ferrule_v2 b) {
  const ferrule_v2 v = {a.y + b.y, a.z + b.z};
  return v;
}
static inline ferrule_v2 ferrule_difference(ferrule_v2 a, ferrule_v2 b) {
  const ferrule_v2 v = {a.y - b.y, a.z - b.z};
  return v;
}
static inline ferrule_v2 ferrule_times(double k, ferrule_v2 a) {
  const ferrule_v2 v = {k * a.y, k * a.z};
  return v;
}
static inline ferrule_v2 ferrule_over(ferrule_v2 a, double k) {
  const ferrule_v2 v = {a.y / k, a.z / k};
  return v;
}
// a turned by a quarter, from y to z.
static inline ferrule_v2 ferrule_turned(ferrule_v2 a) {
  const ferrule_v2 v = {-a.z, a.y};
  return v;
}
static inline double ferrule_dot(ferrule_v2 a, ferrule_v2 b) {
  return a.y * b.y + a.z * b.z;
}
static inline double ferrule_norm(ferrule_v2 a) {
  return sqrt(ferrule_dot(a, a));
}
// Of the part along and across: the force's size, squared.
static inline double ferrule_square(ferrule_axes a) {
  return a.x * a.x + a.across.y * a.across.y + a.across.z * a.across.z;
}
// a + k b.
static inline ferrule_axes ferrule_plus(ferrule_axes a, double k, ferrule_axes b) {
  const ferrule_axes v = {a.x + k * b.x, ferrule_sum(a.across, ferrule_times(k, b.across)),
                          ferrule_sum(a.about, ferrule_times(k, b.about))};
  return v;
}

static inline ferrule_axes ferrule_axes_over(ferrule_axes a, double k) {
  const ferrule_axes v = {a.x / k, ferrule_over(a.across, k), ferrule_over(a.about, k)};
  return v;
}

static inline double ferrule_min(double a, double b) {
  return b < a ? b : a;
}
static inline double ferrule_max(double a, double b) {
  return a < b ? b : a;
}
static inline double ferrule_clamp(double x, double low, double high) {
  return x < low ? low : high < x ? high : x;
}
