// What does not change while a fibre is inserted: geometry, laws, holder. Built from a scene
// (sim/scene/scene.hpp). A law that is not there is not modelled and costs nothing.
#pragma once

#include <limits>
#include <optional>

#include "sim/ferrule_profile.hpp"
#include "sim/holder.hpp"
#include "sim/laws/adhesion.hpp"
#include "sim/laws/annulus.hpp"
#include "sim/laws/capillary.hpp"
#include "sim/laws/drag.hpp"
#include "sim/laws/electrostatic.hpp"
#include "sim/laws/friction.hpp"
#include "sim/laws/gravity.hpp"
#include "sim/laws/meniscus.hpp"
#include "sim/laws/quadrature.hpp"
#include "sim/laws/van_der_waals.hpp"
#include "sim/laws/wall.hpp"
#include "sim/state.hpp"

namespace ferrule {

// Whether the fibre's inertia is modelled, and how time is stepped where it (or drag) is.
enum class Dynamics { quasi_static, inertial };
enum class Integrator { backward_euler, bdf2 };

struct World {
  Annulus annulus;
  FerruleProfile profile;
  FibreMass fibre;
  double fibre_young;  // E_o [Pa]
  Holder holder;
  Dynamics dynamics = Dynamics::quasi_static;
  Integrator integrator = Integrator::backward_euler;
  double longest_step = std::numeric_limits<double>::infinity();  // longer ones are divided [s]
  // A step in which a contact or bridge opens or closes, or the fibre snaps, is halved until the
  // hand travels no more than this in it [m].
  double event_travel = std::numeric_limits<double>::infinity();
  Quadrature quadrature;  // of surface forces along the inserted length
  // Corrected van der Waals and electrostatic forces in closed form instead (surface_forces.hpp).
  bool closed_form = true;

  std::optional<VanDerWaals> van_der_waals;
  std::optional<Electrostatic> electrostatic;
  std::optional<Gravity> gravity;
  std::optional<Capillary> capillary;
  std::optional<Adhesion> adhesion;
  std::optional<Wall> wall;  // empty beside the corrected adhesion, which pushes back by itself
  std::optional<Friction> friction;
  std::optional<Drag> drag;
  std::optional<Meniscus> meniscus;
};

// State of a fibre whose end rests at `tip` in free air, with the command that holds it there
// against gravity.
State at_rest(const World& world, const Pose& tip) noexcept;

// Contact radius [m] that friction takes at penetration `depth` [m]: prescribed by the printed
// form, else that of the adhesion (6c) or, without adhesion, of Hertz.
double friction_radius(const World& world, double depth, int branch) noexcept;

}  // namespace ferrule
