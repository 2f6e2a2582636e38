// What does not change while a fibre is inserted: geometry, laws, holder. Built from a scene
// (sim/scene.hpp). A law that is not there is not modelled and costs nothing.
#pragma once

#include <optional>

#include "sim/adhesion.hpp"
#include "sim/annulus.hpp"
#include "sim/capillary.hpp"
#include "sim/electrostatic.hpp"
#include "sim/ferrule_profile.hpp"
#include "sim/friction.hpp"
#include "sim/gravity.hpp"
#include "sim/state.hpp"
#include "sim/van_der_waals.hpp"
#include "sim/wall.hpp"

namespace ferrule {

// The rigid hand of the paper: a virtual coupling between the commanded pose and the fibre's end.
//   energy = (k |p - p_hand|^2 + k_tilt |tilt - tilt_hand|^2) / 2
struct RigidHand {
  double stiffness;       // k [N/m], > 0, in each direction
  double tilt_stiffness;  // k_tilt [N m/rad], > 0
};

struct World {
  Annulus annulus;
  FerruleProfile profile;
  FibreMass fibre;
  double fibre_young;  // E_o [Pa]
  RigidHand holder;

  std::optional<VanDerWaals> van_der_waals;
  std::optional<Electrostatic> electrostatic;
  std::optional<Gravity> gravity;
  std::optional<Capillary> capillary;
  std::optional<Adhesion> adhesion;
  Wall wall;
  std::optional<Friction> friction;
};

// Gap of the fibre's axis to the bore at arm s behind the end [m] is c - |eccentricity|; this is
// the eccentricity vector there.
inline Vector2d eccentricity(const Pose& tip, double s) noexcept {
  return tip.segment<2>(1) + s * tip.tail<2>();
}

// State of a fibre whose end rests at `tip` in free air: the hand holds it there against gravity.
State at_rest(const World& world, const Pose& tip) noexcept;

}  // namespace ferrule
