// Where the fibre touches, as functions of its pose: how deep, with gradient and Hessian.
//
// The end's rim meets the bore wall, the lead-in cone or the front face (sim/ferrule_profile.hpp);
// its side meets the rim of the bore's mouth. First order in the tilts: the rim of the end lies r
// (outward.tilt) ahead of the end's centre.
#pragma once

#include <array>

#include "sim/world.hpp"

namespace ferrule {

// Eccentricity |e| of the fibre's axis, smoothed to sqrt(e^2 + (c/1000)^2) where its direction is
// undefined on the bore's axis, with derivatives by the vector e.
struct Radial {
  double eccentricity;      // [m]
  Vector2d normal;          // d eccentricity / de, of length <= 1
  Eigen::Matrix2d curving;  // d normal / de [1/m]

  Radial(const Vector2d& e, double clearance) noexcept;
};

// The depth d [m] of one contact; -infinity where there is none.
struct ContactDepth {
  double value = -INFINITY;
  Pose gradient = Pose::Zero();
  Matrix5 hessian = Matrix5::Zero();
  Vector3d normal = Vector3d::Zero();  // from the ferrule into the fibre, unit
  // Where the contact acts, to first order in the tilts: so that the wrench of `normal` there is
  // minus the gradient.
  Vector3d point = Vector3d::Zero();
};

// What a step holds fixed about the contacts (sim/potential.hpp).
struct ContactSide {
  EdgeSide side = EdgeSide::throat;
  Vector2d outward = Vector2d::UnitX();  // unit direction from the bore's axis to the fibre's end
  bool side_can_touch = false;           // the end is in the bore: the mouth's rim faces the side
};

ContactSide contact_side(const World& world, const State& state) noexcept;

std::array<ContactDepth, kContactPlaces> contact_depths(const World& world, const ContactSide& side,
                                                        const Pose& tip) noexcept;

// A vector across the bore in three dimensions.
inline Vector3d across(const Vector2d& n) noexcept {
  return {0, n.x(), n.y()};
}

}  // namespace ferrule
