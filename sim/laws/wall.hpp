// The solid resistance of a closed contact: Hertz (1882).
//
//   F = K sqrt(R_s) (d - d_0)^(3/2) for d > d_0, else 0;  repulsion positive.
//
// d_0 is 0, or 10 nm beside the printed adhesion (6), which prescribes what happens up to there.
#pragma once

#include "sim/laws/adhesion.hpp"

namespace ferrule {

struct Wall {
  double reduced_modulus;  // K [Pa], > 0
  double radius;           // R_s [m], > 0
  double begins;           // d_0 [m], >= 0
};

ContactForce wall(const Wall& law, double depth) noexcept;

}  // namespace ferrule
