// Where the fibre touches, as functions of its pose: how deep, with gradient and Hessian.
//
// The end's rim meets the bore wall, the lead-in cone or the front face
// (sim/geometry/ferrule_profile.hpp); its side meets the rim of the bore's mouth. First order in
// the tilts: the rim of the end lies r outward.(tilt + cleave) ahead of the end's centre. In the
// throat it touches where it is deepest, and so does a rounded rim on the face; a sharp one rests
// on the face where it is lowest (sim/geometry/face_support.hpp).
//
// Where it is deepest it is as deep as the circle that it is rounded to, in the half plane, of
// radius rho and with its centre at (x + s, r - rho), is in the solid: touching it at the angle
// alpha, 0 on the bore and 90 degrees on the face, with the edge at (x_v, R_v) that has such a
// tangent,
//   d = min over alpha of rho - (x + s - x_v) sin(alpha) - (R_v - r + rho) cos(alpha)
//                         + |(e + s tilt) cos(alpha) + (r - rho)(tilt + cleave) sin(alpha)|,
// the last term being what the direction adds in which the rim is deepest. So the end goes round
// the edges of bore and cone. A rounded rim has s = rho, and an upright one goes into a sharp bore
// from within c + rho of its axis. A sharp rim is rounded to kSharpRounding with s = 0: in the
// bore it is a sharp one, on the cone rho (1 - cos(alpha)) deeper, 27 nm on one of 60 degrees, and
// at the throat one point of it after the other goes over from one to the other. The face is rho
// farther back for it, so that over the mouth's edge an end is as high as on the face.
#pragma once

#include <array>
#include <cmath>

#include "sim/geometry/energy.hpp"
#include "sim/geometry/geometry.hpp"

namespace ferrule {

// The two places where the fibre can touch: the rim of its end (on the bore wall, the lead-in cone
// or the front face) and its side (on the rim of the bore's mouth).
enum ContactPlace { kEnd = 0, kSide = 1, kContactPlaces = 2 };

// Eccentricity |e| of the fibre's axis, with derivatives by the vector e. On the bore's axis, where
// its direction is undefined, it is smoothed: within s = c/1000 of the axis it is
// s (3 + 6 q - q^2)/8, q = (e/s)^2, which goes over into |e| with two derivatives.
inline constexpr double kRadialSmoothing = 1e-3;  // of the clearance

struct Radial {
  double eccentricity;         // [m]
  Vector2d normal;             // d eccentricity / de, of length <= 1
  Matrix2d curving;            // d normal / de [1/m]
  double wider = 0;            // by what an oval bore is wider there [m]
  Vector2d wider_by = {0, 0};  // d wider / de

  Radial(const Vector2d& e, double clearance) noexcept {
    const double smooth = kRadialSmoothing * clearance, squared = e.squaredNorm();
    const bool off_axis = squared >= smooth * smooth;
    const double inverse = 1 / (off_axis ? std::sqrt(squared) : smooth);
    const double q = off_axis ? 1 : squared * inverse * inverse;
    eccentricity = off_axis ? std::sqrt(squared) : smooth * (3 + q * (6 - q)) / 8;
    const double turn = inverse * (1.5 - 0.5 * q);  // 1/|e| off the axis
    normal = turn * e;
    const Vector2d bend = -inverse * inverse * inverse * e;
    curving = turn * kIdentity + bend * e.transpose();
  }

  // Less what an oval bore is wider there, times `share`; on the axis, where its direction is
  // undefined, smoothed within a tenth of the clearance: a hundredth of it is missing at the wall.
  Radial(const Vector2d& e, const Geometry& geometry, double share = 1) noexcept
      : Radial(e, geometry.annulus.clearance()) {
    if (geometry.oval.round()) return;
    const double smooth = 0.1 * geometry.annulus.clearance(), q = share * geometry.oval.amplitude;
    const Vector2d& u = geometry.oval.widest;
    const double inverse = 1 / (e.squaredNorm() + smooth * smooth), w = u.dot(e) * inverse;
    wider = geometry.oval.amplitude * (2 * w * u.dot(e) - 1);
    wider_by = 4 * geometry.oval.amplitude * w * (u - w * e);
    eccentricity -= share * wider;
    normal -= share * wider_by;
    const Matrix2d mixed = u * e.transpose();
    curving -= 4 * q * inverse *
               (u * u.transpose() - 2 * w * (mixed + mixed.transpose()) +
                w * w * (4 * e * e.transpose() - kIdentity / inverse));
  }
};

// A vector across the bore in three dimensions.
inline Vector3d across(const Vector2d& n) noexcept {
  return {0, n.x(), n.y()};
}

// The depth d [m] of one contact, -infinity where there is none, as a function of the point
//   p = (x + offset.tilt, eccentricity at `arm`),
// with its derivatives by that.
struct ContactDepth {
  double value = -INFINITY;  // the rest is only set where there is a contact
  Arm arm;                   // fixed to the ferrule only where d does not depend on x
  Vector2d offset;           // [m]
  Vector3d slope;            // [-]
  Matrix2d curve;            // by the eccentricity [1/m]
  // On the cone the deepest point of the rim turns with the tilts: d bends by the eccentricity at
  // this arm, too, with the same slope.
  double cone_arm = 0;                     // [m]
  Matrix2d cone_curve = Matrix2d::Zero();  // [1/m]
  // On an edge it bends also by -edge u u^T, u = `over_edge` by the pose [1/m].
  double edge = 0;
  PoseVector over_edge;
  // Where the end rests on the face it turns with the tilts: d bends by them [m].
  bool rests = false;
  Matrix2d tilt_curve, mixed_curve;  // by the tilts; by eccentricity and tilts
  // Where it acts, to first order in the tilts: so that the wrench of its normal there is minus the
  // gradient of its depth [m].
  Vector3d point;

  // From the ferrule into the fibre, unit.
  Vector3d normal(const Vector2d& tilt) const noexcept {
    const Vector2d n = slope.tail<2>();
    return arm.per_x == 0 ? Vector3d(-slope) : Vector3d(n.dot(tilt), -n.x(), -n.y());
  }

  // Its derivative by the pose, whose tilt is given.
  PoseVector by_pose(const Vector2d& tilt) const noexcept {
    const Vector2d n = slope.tail<2>();
    return {slope[0] + arm.per_x * n.dot(tilt), n, slope[0] * offset + arm.length * n};
  }

  // Adds an energy of the depth, given its derivatives by that.
  void add_to(Energy& total, const Vector2d& tilt, double force, double stiffness) const noexcept {
    if (slope[0] == 0) {
      const Vector2d n = slope.tail<2>();
      total.add_across(tilt, arm, force * n, force * curve + stiffness * n * n.transpose());
    } else {
      Matrix3d k = stiffness * slope * slope.transpose();
      k.bottomRightCorner<2, 2>() += force * curve;
      total.add_point(arm.length, offset, force * slope, k);
      if (edge > 0) add_square(total.hessian, -force * edge, over_edge);
      if (rests) {
        total.hessian.tt += force * tilt_curve;
        total.hessian.et += force * mixed_curve;
        return;
      }
      const Matrix2d turn = force * cone_curve;
      total.hessian.ee += turn;
      total.hessian.et += cone_arm * turn;
      total.hessian.tt += cone_arm * cone_arm * turn;
    }
  }
};

// What a step holds fixed about the contacts (sim/terms/frozen_coefficients.hpp).
struct ContactSide {
  EdgeSide side = EdgeSide::throat;
  // Unit directions to where the fibre is nearest to the ferrule: from the centre of its end, and
  // from the bore's axis at the mouth.
  Vector2d outward = Vector2d::UnitX(), mouth_outward = Vector2d::UnitX();
  double side_ahead = 0;  // of an upright end's centre the side begins: less than 0 by its edge [m]

  // Length of the side [m] that is past the mouth where it is nearest to the mouth's rim: there the
  // rim of the end is r mouth_outward.tilt ahead of its centre. <= 0 outside.
  double past_mouth(const PoseVector& tip, double fibre_radius) const noexcept {
    return side == EdgeSide::face ? 0
                                  : fibre_radius * mouth_outward.dot(tip.t) + side_ahead - tip.x;
  }
};

// Of an end at `tip` that was on the side `before`.
ContactSide contact_side(const Geometry& geometry, const PoseVector& tip, EdgeSide before) noexcept;

// Which side an end at `tip` is on that was on the side `before`: the face where it is in front of
// it, or its rim's circle has its centre over it.
EdgeSide side_of(const Geometry& geometry, const PoseVector& tip, EdgeSide before) noexcept;

std::array<ContactDepth, kContactPlaces> contact_depths(const Geometry& geometry,
                                                        const ContactSide& side,
                                                        const PoseVector& tip) noexcept;

}  // namespace ferrule
