// The gap between a fibre and a bore with parallel axes.
//
//   c = R - r     radial clearance [m]
//   e             eccentricity, the distance between the two axes [m], 0 <= e
//   h = c - e     smallest distance between fibre and bore [m]; h < 0 is overlap
//
// Rough surfaces: the mean planes of the solids never come closer than the roughness, so surface
// forces act across h + roughness (6r).
#pragma once

namespace ferrule {

inline constexpr double kInteratomicDistance = 0.1e-9;  // a_0 [m], Table I

struct Annulus {
  double fibre_radius;   // r [m], > 0
  double bore_radius;    // R [m], > r
  double roughness = 0;  // smallest distance of the mean planes [m], >= 0

  double clearance() const noexcept { return bore_radius - fibre_radius; }
};

// A surface force per unit of inserted length [N/m] against the gap h, with its potential and its
// slope. The force acts along the line of the smallest gap; attraction is negative.
//   force = -d potential / dh,   slope = d force / dh
struct LineForce {
  double potential = 0;  // [J/m]
  double force = 0;      // [N/m]
  double slope = 0;      // [N/m^2]
};

}  // namespace ferrule
