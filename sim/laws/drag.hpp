// Drag of liquid that fills the gap (adhesive: 0.1 to 5 Pa s).
//
// Inserted length l, fibre radius r, clearance c, eccentricity e (relative: eps = e/c):
//   along x:    Couette flow, F = -2 pi mu r l v_x / sqrt(c^2 - e^2)
//   sideways:   squeeze film of the short journal bearing, full film (Pinkus and Sternlicht 1961)
//     F_radial     = -mu r l^3/c^3 pi (1 + 2 eps^2)/(1 - eps^2)^(5/2) v_radial
//     F_tangential = -mu r l^3/c^3 pi / (1 - eps^2)^(3/2) v_tangential
//   in tilting: M = -(l^2/60) times the same coefficients times the rate
// c is enlarged by the roughness, so that all stay finite in contact. Air (1.8e-5 Pa s) gives
// forces 1e4 times below those of a thin adhesive: negligible, and not computed.
#pragma once

#include "sim/geometry/annulus.hpp"

namespace ferrule {

struct Drag {
  double viscosity;  // mu [Pa s], > 0
};

struct DragCoefficients {
  double axial = 0;       // [N s/m]
  double radial = 0;      // [N s/m]
  double tangential = 0;  // [N s/m]
};

// Where the lubrication gap is thinner than this, its coefficients are held [m].
inline constexpr double kThinnestFilm = 1e-9;

// At eccentricity e >= 0 [m] and inserted length >= 0 [m].
DragCoefficients drag(const Drag& law, const Annulus& annulus, double eccentricity,
                      double length) noexcept;

}  // namespace ferrule
