// Capillary attraction of liquid between fibre and bore, (4c): a bridge of constant volume along
// the line of the smallest gap, with a meniscus on either side.
//
// With A_l its volume per length, d = h + roughness the distance of the mean planes (Rabinovich et
// al. 2002, "Capillary forces between surfaces with nanoscale roughness": asperities hold the
// surfaces that the liquid joins apart) and R_e = r R/(R - r), the half width x solves
//   A_l = 2 (d x + x^3/(6 R_e));   the gap there is H = d + x^2/(2 R_e)
//   f = -4 gamma_L cos(theta_c) x/H,   potential -4 gamma_L cos(theta_c) x   (f = -dw/dh exactly)
// It forms when two films meet, h < 2 e, and ruptures beyond a stated distance: two different
// distances, so whether there is a bridge is state. Where rough surfaces touch the liquid between
// them stays, and so does its pull: in contact, h < 0, the force is that at h = 0.
//
// Of a film in droplets A_l is the mean along the length: while they are much narrower than
// sqrt(2 R_e d) the force is proportional to it.
#pragma once

#include <span>

#include "sim/geometry/annulus.hpp"
#include "sim/laws/quadrature.hpp"

namespace ferrule {

struct Capillary {
  double surface_tension;  // gamma_L [N/m], > 0
  double contact_angle;    // theta_c [rad], 0 <= theta_c < pi/2 (wetting)
  double film;             // e, thickness of the liquid layer [m], > 0
  double volume;           // A_l, per length [m^2], > 0
  double rupture;          // gap at which a bridge ruptures [m], > 2 e

  // Derived, by prepare(): half widths of a bridge where it ruptures and where it forms [m].
  // Without them they are computed at each call.
  double rupture_half_width = 0, film_half_width = 0;
};

Capillary prepare(Capillary law, const Annulus& annulus) noexcept;

// Where the force ends on the way out [m]: the rupture of a bridge, or the films' meeting where
// there is none yet.
double capillary_range(const Capillary& law, bool bridge) noexcept;

// Gap over which the force of a bridge falls [m]: beyond contact its half width is a function of
// h/scale that is singular at -1 or below.
double bridge_scale(const Capillary& law, const Annulus& annulus) noexcept;

// Force per inserted length at gap h [m], any finite h. Zero, with a constant potential, beyond
// capillary_range(law, bridge).
LineForce capillary(const Capillary& law, const Annulus& annulus, double h, bool bridge) noexcept;
// The same at several gaps, kMostNodes at most, which takes less time.
void capillary(const Capillary& law, const Annulus& annulus, bool bridge,
               std::span<const double> gaps, std::span<LineForce> forces) noexcept;

}  // namespace ferrule
