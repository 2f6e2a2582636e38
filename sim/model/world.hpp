// What does not change while a fibre is inserted: geometry, laws, holder, and how they are
// computed. Built from what a scene states (sim/scene/world_parameters.hpp).
#pragma once

#include "sim/geometry/geometry.hpp"
#include "sim/laws/laws.hpp"
#include "sim/model/holder.hpp"
#include "sim/model/numerics.hpp"
#include "sim/model/state.hpp"

namespace ferrule {

// Whether the fibre's inertia is modelled.
enum class Dynamics { quasi_static, inertial };

struct World : Geometry {
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
