// What does not change while a fibre is inserted: geometry, laws, holder, and how they are
// computed. Built from what a scene states (sim/scene/world_parameters.hpp).
#pragma once

#include "sim/ferrule_profile.hpp"
#include "sim/holder.hpp"
#include "sim/laws/annulus.hpp"
#include "sim/laws/laws.hpp"
#include "sim/numerics.hpp"
#include "sim/oval_bore.hpp"
#include "sim/state.hpp"

namespace ferrule {

// Whether the fibre's inertia is modelled.
enum class Dynamics { quasi_static, inertial };

// The radius at which a sharp rim goes round the throat's edges [m]: over a corner the contact's
// normal would turn at once, and where friction leaves the end would depend on the step.
inline constexpr double kSharpRounding = 200e-9;

// The fibre's end as it is cleaved and its rim is worn or polished.
struct FibreEnd {
  // Slope of its face against the fibre's cross-section [rad]: the rim at the direction n lies
  // r (n.cleave) ahead.
  Vector2d cleave = Vector2d::Zero();
  double edge = 0;  // radius that its rim is rounded to [m]; 0: sharp
  // Whether a sharp one rests on the front face where it is lowest (sim/face_support.hpp), or as if
  // it were upright where it is farthest from the bore.
  bool rests_lowest = false;
  // How far behind the centre of its face the fibre is whole around: r |cleave| + rho [m]. Surface
  // forces act from there on.
  double behind = 0;

  bool rounded() const noexcept { return edge > 0; }
  // Radius rho of the rim in the throat [m] (sim/contact_depth.hpp).
  double rounding() const noexcept { return rounded() ? edge : kSharpRounding; }
};

struct World {
  Annulus annulus;
  OvalBore oval;
  FibreEnd end;
  FerruleProfile profile;
  FibreMass fibre;
  double fibre_young;  // E_o [Pa]
  Holder holder;
  Dynamics dynamics = Dynamics::quasi_static;
  Laws laws;
  Numerics numerics;
};

// State of a fibre whose end rests at `tip` in free air: the holder is where it hangs there against
// gravity.
State at_rest(const World& world, const Pose& tip) noexcept;

struct ContactRadius {
  double value = 0;      // [m]
  double per_depth = 0;  // its derivative by the penetration [-]
};

// The contact radius that friction takes at penetration `depth` [m]: prescribed by the printed
// form, else that of the adhesion (6c), whose force there is `pull`, or, without adhesion, of
// Hertz.
ContactRadius friction_radius(const World& world, double depth, const AdhesionForce& pull) noexcept;
ContactRadius friction_radius(const World& world, double depth, int branch) noexcept;

// Of the adhesion, in either form; no force without it.
AdhesionForce adhesion_force(const Laws& laws, double depth, int branch) noexcept;

}  // namespace ferrule
