// The shapes of fibre and ferrule.
#pragma once

#include "sim/geometry/annulus.hpp"
#include "sim/geometry/ferrule_profile.hpp"
#include "sim/geometry/oval_bore.hpp"

namespace ferrule {

// The radius at which a sharp rim goes round the throat's edges [m]: over a corner the contact's
// normal would turn at once, and where friction leaves the end would depend on the step.
inline constexpr double kSharpRounding = 200e-9;

// The fibre's end as it is cleaved and its rim is worn or polished.
struct FibreEnd {
  // Slope of its face against the fibre's cross-section [rad]: the rim at the direction n lies
  // r (n.cleave) ahead.
  Vector2d cleave = Vector2d::Zero();
  double edge = 0;  // radius that its rim is rounded to [m]; 0: sharp
  // How far behind the centre of its face the fibre is whole around: r |cleave| + rho [m]. Surface
  // forces act from there on.
  double behind = 0;

  bool rounded() const noexcept { return edge > 0; }
  // Radius rho of the rim in the throat [m] (sim/geometry/contact_depth.hpp).
  double rounding() const noexcept { return rounded() ? edge : kSharpRounding; }
};

struct Geometry {
  Annulus annulus;
  OvalBore oval;
  FibreEnd end;
  FerruleProfile profile;
};

}  // namespace ferrule
