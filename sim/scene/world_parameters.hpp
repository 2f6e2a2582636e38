// What a scene states of a world, number by number, and the world that follows from it.
#pragma once

#include <optional>
#include <variant>

#include "sim/model/world.hpp"

namespace ferrule {

inline constexpr double kSharpestEdge = 0.05;  // the least edge_um [um]

// Geometry, materials and holder in the units of the scene file (data/README.md), so that what is
// computed from a number is the same whether it was read, drawn or varied.
struct FibreParameters {
  double diameter_um, density_kg_m3, young_GPa, poisson, shear_GPa, manipulated_length_mm;
  std::optional<double> curl_radius_m;  // of its natural curvature; none: straight
  // How it lies in the gripper, turned about its axis from y to z; none: chance decides.
  std::optional<double> roll_deg;
  // Angle of its end's face to the cross-section; none: square, and it rests on the front face as
  // if it were upright. Its leading rim point lies at that direction from the roll angle; none:
  // chance decides.
  std::optional<double> cleave_deg, cleave_direction_deg;
  // Radius that its rim is rounded to; none: sharp.
  std::optional<double> edge_um;
};

struct LeadIn {
  double angle_deg, diameter_um;  // full angle; where it meets the face
};

struct FerruleParameters {
  double bore_diameter_um, length_mm, young_GPa, poisson, shear_GPa;
  std::optional<LeadIn> lead_in;
  // Largest less smallest diameter, and where the largest lies; none: round, chance decides.
  std::optional<double> ovality_um, ovality_direction_deg;
};

// The rigid hand of the paper, or an elastic fibre in a gripper (sim/model/holder.hpp).
struct RigidHand {
  double stiffness_N_m, tilt_stiffness_N_m_rad;
};
struct ElasticFibre {
  double free_length_mm, gripper_stiffness_N_m;
  double loss_factor = 0;  // of its bending; 0: none is stated
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

// What a smooth interval may be off by where a scene does not state it: of the clearance and of the
// force limit; of the end [m].
inline constexpr double kUsualTangent = 1e-5;
double usual_tangent_tip(const WorldParameters& p) noexcept;

// The largest ovality of a bore, of what it is wider than the fibre: q < c/3, so that the clearance
// is convex (sim/geometry/oval_bore.hpp).
inline constexpr double kMostOval = 0.6;

// Length of fibre between its end and what holds it [m].
double free_length(const WorldParameters& parameters) noexcept;

// What its curl does to a fibre that is free of load (sim/geometry/curl.hpp).
struct FreeCurl {
  double aside;  // of its end [m]
  double tilt;   // [rad]
  double force;  // across the end that holds it straight, free to tilt: 3 E I/(2 R L) [N]
};
// Empty for a straight fibre.
std::optional<FreeCurl> free_curl(const WorldParameters& parameters) noexcept;

// Why two of these numbers cannot be together.
struct Inconsistency {
  std::string key;   // dotted, of the number that must change
  std::string rule;  // what it must be
};
std::optional<Inconsistency> inconsistency(const WorldParameters& parameters);

// The bore, as it lies.
OvalBore oval_bore(const WorldParameters& parameters) noexcept;

// The fibre's end, as it lies.
FibreEnd fibre_end(const FibreParameters& fibre) noexcept;

// The particle on the wall, if there is one. Before chance decides: as high as hardly any
// (unusual_height), but no higher than c, so that fibres pass, in the direction of y, as near the
// entrance as one may be.
std::optional<Particle> particle(const WorldParameters& parameters) noexcept;

// The least depth of a particle of that height [m].
double shallowest(const WorldParameters& parameters, double height) noexcept;

// The parameters are consistent and each in its range (data/README.md).
World make_world(const WorldParameters& parameters);

}  // namespace ferrule
