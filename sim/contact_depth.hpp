// Where the fibre touches, as functions of its pose: how deep, with gradient and Hessian.
//
// The end's rim meets the bore wall, the lead-in cone or the front face (sim/ferrule_profile.hpp);
// its side meets the rim of the bore's mouth. First order in the tilts: the rim of the end lies r
// (outward.tilt) ahead of the end's centre.
#pragma once

#include <array>
#include <cmath>

#include "sim/energy.hpp"
#include "sim/world.hpp"

namespace ferrule {

// Eccentricity |e| of the fibre's axis, smoothed to sqrt(e^2 + (c/1000)^2) where its direction is
// undefined on the bore's axis, with derivatives by the vector e.
inline constexpr double kRadialSmoothing = 1e-3;  // of the clearance

struct Radial {
  double eccentricity;  // [m]
  Vector2d normal;      // d eccentricity / de, of length <= 1
  Matrix2d curving;     // d normal / de [1/m]

  Radial(const Vector2d& e, double clearance) noexcept {
    const double smooth = kRadialSmoothing * clearance;
    eccentricity = std::sqrt(e.squaredNorm() + smooth * smooth);
    const double inverse = 1 / eccentricity;
    normal = inverse * e;
    curving = -inverse * normal * normal.transpose();
    curving.diagonal().array() += inverse;
  }
};

// The depth d [m] of one contact, -infinity where there is none, as a function of the point p = (x
// + lean.tilt, eccentricity at `arm`), with its derivatives by that.
struct ContactDepth {
  double value = -INFINITY;
  Arm arm;                             // fixed to the ferrule only where d does not depend on x
  Vector2d lean = Vector2d::Zero();    // [m]
  Vector3d slope = Vector3d::Zero();   // [-]
  Matrix2d curve = Matrix2d::Zero();   // by the eccentricity [1/m]
  Vector3d normal = Vector3d::Zero();  // from the ferrule into the fibre, unit
  // Where the contact acts, to first order in the tilts: so that the wrench of `normal` there is
  // minus the gradient.
  Vector3d point = Vector3d::Zero();

  // Adds an energy of the depth, given its derivatives by that.
  void add_to(Energy& total, const Vector2d& tilt, double force, double stiffness) const noexcept {
    if (slope[0] == 0) {
      const Vector2d n = slope.tail<2>();
      total.add_across(tilt, arm, force * n, force * curve + stiffness * n * n.transpose());
    } else {
      Matrix3d k = stiffness * slope * slope.transpose();
      k.bottomRightCorner<2, 2>() += force * curve;
      total.add_point(arm.length, lean, force * slope, k);
    }
  }
};

// What a step holds fixed about the contacts (sim/potential.hpp).
struct ContactSide {
  EdgeSide side = EdgeSide::throat;
  Vector2d outward = Vector2d::UnitX();  // unit direction from the bore's axis to the fibre's end
  // It was in the bore when the step began: the mouth's rim faces the side, and surface forces act.
  bool side_can_touch = false;
};

ContactSide contact_side(const World& world, const State& state) noexcept;

std::array<ContactDepth, kContactPlaces> contact_depths(const World& world, const ContactSide& side,
                                                        const Pose& tip) noexcept;

// A vector across the bore in three dimensions.
inline Vector3d across(const Vector2d& n) noexcept {
  return {0, n.x(), n.y()};
}

}  // namespace ferrule
