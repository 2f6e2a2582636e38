// What a scene states of a world, number by number, and the world that follows from it.
#pragma once

#include <optional>
#include <variant>

#include "sim/world.hpp"

namespace ferrule {

// Geometry, materials and holder in the units of the scene file (data/README.md), so that what is
// computed from a number is the same whether it was read, drawn or varied.
struct FibreParameters {
  double diameter_um, density_kg_m3, young_GPa, poisson, shear_GPa, manipulated_length_mm;
};

struct LeadIn {
  double angle_deg, diameter_um;  // full angle; where it meets the face
};

struct FerruleParameters {
  double bore_diameter_um, length_mm, young_GPa, poisson, shear_GPa;
  std::optional<LeadIn> lead_in;
};

// The rigid hand of the paper, or an elastic fibre in a gripper (sim/holder.hpp).
struct RigidHand {
  double stiffness_N_m, tilt_stiffness_N_m_rad;
};
struct ElasticFibre {
  double free_length_mm, gripper_stiffness_N_m;
};

struct WorldParameters {
  FibreParameters fibre;
  FerruleParameters ferrule;
  double roughness_nm;
  // In SI, as stated: what follows from the rest (moduli, tables, the wall) is left to make_world.
  // An adhesion whose radius is not stated has NaN there.
  Laws laws;
  std::variant<RigidHand, ElasticFibre> holder;
  Dynamics dynamics = Dynamics::quasi_static;
  Numerics numerics;
};

// Why two of these numbers cannot be together.
struct Inconsistency {
  std::string key;   // dotted, of the number that must change
  std::string rule;  // what it must be
};
std::optional<Inconsistency> inconsistency(const WorldParameters& parameters);

// The parameters are consistent and each in its range (data/README.md).
World make_world(const WorldParameters& parameters);

}  // namespace ferrule
