#include "sim/geometry/contact_depth.hpp"

#include <algorithm>
#include <cmath>

#include "sim/geometry/face_support.hpp"

namespace ferrule {
namespace {

// Slope of the end's face against the ferrule's.
Vector2d face_slope(const Geometry& geometry, const PoseVector& tip) noexcept {
  return tip.t + geometry.end.cleave;
}

// The end on the front face, where it is lowest; second derivatives as it moves over the opening by
// central differences.
ContactDepth face_depth(const Geometry& geometry, const PoseVector& tip) noexcept {
  constexpr double kApart = 1e-9;  // [m]
  ContactDepth depth;
  const double r = geometry.annulus.fibre_radius;
  const double opening = geometry.profile.mouth_radius();
  const Vector2d slope = face_slope(geometry, tip);
  depth.point = tip.position();
  const FaceSupport support(r, opening, tip.e);
  if (!support.any()) return depth;
  const FaceSupport::Rest rest = support.rest(slope);
  depth.value = geometry.profile.lead_in_length - tip.x + rest.ahead;
  depth.offset = -rest.point;
  depth.slope << -1, rest.by_e;
  depth.curve.setZero();
  depth.rests = true;
  depth.tilt_curve = rest.turning;
  depth.mixed_curve.setZero();
  for (int i = 0; i < 2; ++i) {
    const Vector2d apart = kApart * kIdentity.col(i);
    const FaceSupport up(r, opening, tip.e + apart), down(r, opening, tip.e - apart);
    if (!up.any() || !down.any()) continue;
    const FaceSupport::Rest more = up.rest(slope), less = down.rest(slope);
    depth.curve.row(i) = (more.by_e - less.by_e).transpose() / (2 * kApart);
    depth.mixed_curve.row(i) = (more.point - less.point).transpose() / (2 * kApart);
  }
  depth.curve = 0.5 * (depth.curve + depth.curve.transpose()).eval();
  depth.point.tail<2>() += rest.point;
  return depth;
}

// The rim on bore, cone and the edges between bore, cone and face (sim/geometry/contact_depth.hpp).
class Rim {
 public:
  Rim(const Geometry& geometry, const PoseVector& tip) noexcept
      : geometry_(geometry),
        rho_(geometry.end.rounding()),
        lever_(geometry.annulus.fibre_radius - rho_),
        behind_(geometry.end.edge),
        face_(geometry.profile.lead_in_length - (rho_ - behind_)),
        high_(tip.x + behind_ - std::min(face_, 0.0)),
        across_(eccentricity(tip, behind_)),
        slope_(face_slope(geometry, tip)),
        there_(along(normal_, high_, geometry.annulus.clearance() + rho_)) {
    if (there_.slope >= 0 && there_.depth < rho_) return;  // all of it is in the bore
    const FerruleProfile& profile = geometry.profile;
    const Vector2d bore(1, 0), face(kLeastCosine, 1);
    const double wide = geometry.annulus.clearance() + rho_;
    if (!(face_ > 0)) {
      look(bore, face, high_, wide, Along(there_));
      return;
    }
    const double cosine = profile.lead_in_cosine();
    const Vector2d cone(cosine, profile.lead_in_tangent * cosine);
    if (!look(bore, cone, high_, wide, Along(there_))) return;
    const double high = high_ - face_, at_face = wide + face_ * profile.lead_in_tangent;
    look(cone, face, high, at_face, along(cone, high, at_face));
  }

  const Vector2d& outward() const noexcept { return there_.radial.normal; }

  void set(const PoseVector& tip, ContactDepth& d) const noexcept {
    const double c = normal_[0], s = normal_[1];
    const Radial& radial = there_.radial;
    const Vector2d& n = radial.normal;
    d.value = there_.depth;
    d.arm.length = behind_;
    d.offset = -lever_ * n;
    d.slope << -s, c * n;
    d.point << tip.x + behind_ - rho_ * s, tip.e + (lever_ + rho_ * c) * n;
    if (s == 0) {
      d.curve = radial.curving;
      return;
    }
    d.curve.setZero();
    d.cone_arm = behind_ + lever_ * s / c;
    d.cone_curve = c * c * radial.curving;
    if (bend_ > 0) {
      d.edge = 1 / bend_;
      // By the angle the slope turns, and with it the direction in which the rim is deepest.
      const Vector2d turn = turning(radial, normal_);
      d.over_edge = {c, s * n - c * turn, (s * behind_ - c * lever_) * n - c * d.cone_arm * turn};
    }
  }

 private:
  static constexpr double kLeastCosine = 1e-6;  // of 90 degrees
  static constexpr int kTurns = 20;             // of the angle, until it does not change

  static double cross(const Vector2d& a, const Vector2d& b) noexcept {
    return a.x() * b.y() - a.y() * b.x();
  }
  static Vector2d within(const Vector2d& v, const Vector2d& from, const Vector2d& to) noexcept {
    if (!(cross(from, v) > 0)) return from;
    return cross(v, to) > 0 ? v.normalized() : to;
  }
  // What adds to the depth across the bore is |m|; what that vector m changes by with the angle.
  Vector2d turned(const Vector2d& at) const noexcept {
    return -at[1] * across_ + at[0] * lever_ * slope_;
  }

  // And its normal: in an oval bore also by the share of what that is wider.
  Vector2d turning(const Radial& radial, const Vector2d& at) const noexcept {
    return radial.curving * turned(at) + at[1] * radial.wider_by;
  }

  // The angle at which the vector itself is shortest, or one below 0.
  Vector2d shortest() const noexcept {
    const Vector2d offset = lever_ * slope_;
    const double more = across_.squaredNorm() - offset.squaredNorm(),
                 both = 2 * across_.dot(offset);
    const double least = std::sqrt(more * more + both * both);
    if (!(both < 0)) return {1, -1};
    return {std::sqrt(0.5 * (1 - more / least)), std::sqrt(0.5 * (1 + more / least))};
  }

  // The depth at an angle, and what it changes by with that.
  struct Along {
    Radial radial;  // |m|, with derivatives by m
    double depth, slope;
  };
  Along along(const Vector2d& at, double high, double wide) const noexcept {
    const Radial radial(at[0] * across_ + at[1] * lever_ * slope_, geometry_, at[0]);
    return {radial, rho_ - high * at[1] + radial.eccentricity - wide * at[0],
            (wide + radial.wider) * at[1] - high * at[0] + radial.normal.dot(turned(at))};
  }
  // What its slope changes by with that.
  double bend(const Along& there, const Vector2d& at) const noexcept {
    const Vector2d by = turned(at);
    return rho_ - there.depth + by.dot(turning(there.radial, at)) +
           at[1] * there.radial.wider_by.dot(by);
  }

  void keep(const Vector2d& at, const Along& there, double bend) noexcept {
    if (!(there.depth < there_.depth)) return;
    there_ = there;
    normal_ = at;
    bend_ = bend;
  }

  // At the angles between `from`, where it is `first`, and `to`, about an edge that the centre is
  // `high` in front of: by Newton's method within bounds, as the depth has one minimum where it is
  // less than rho. It is at a bound from which the depth rises. Whether it may be less beyond `to`.
  bool look(const Vector2d& from, const Vector2d& to, double high, double wide,
            const Along& first) noexcept {
    keep(from, first, 0);
    if (first.slope >= 0 && first.depth < rho_) return false;
    const Along last = along(to, high, wide);
    keep(to, last, 0);
    if (last.slope <= 0 && last.depth < rho_) return true;
    Vector2d low = from, most = to, at = shortest();
    // From there, if that is between them: the depth bends most there, to a kink where it is 0.
    if (!(cross(from, at) > 0 && cross(at, to) > 0))
      at = within({wide - across_.norm(), high}, from, to);
    double below = first.slope, above = last.slope;
    Along there = along(at, high, wide);
    for (int turn = 0; turn < kTurns && there.slope != 0; ++turn) {
      (there.slope > 0 ? most : low) = at;
      (there.slope > 0 ? above : below) = there.slope;
      const double bends = bend(there, at), by = bends > 0 ? -there.slope / bends : INFINITY;
      Vector2d next = at + by * Vector2d(-at[1], at[0]);
      if (!(std::abs(by) < 0.5) || cross(low, next) < 0 || cross(next, most) < 0) {
        const bool secant = below < 0 && above > 0 && turn % 3 != 2;
        next = secant ? Vector2d(above * low - below * most) : Vector2d(low + most);
      }
      next.normalize();
      if ((next - at).squaredNorm() < 1e-24) break;
      at = next;
      there = along(at, high, wide);
    }
    keep(at, there, bend(there, at));
    return !(there_.depth < rho_);
  }

  const Geometry& geometry_;
  double rho_, lever_, behind_;
  double face_, high_;  // where the face is, and how far the rim's centre is in front of the bore
  Vector2d across_, slope_;
  Vector2d normal_ = Vector2d::UnitX();  // cos and sin of alpha
  Along there_;
  double bend_ = 0;  // second derivative by alpha where it is free
};

// A rounded rim goes round the edge between throat and face as it does round those in the throat:
// it lies beyond what of the end is flat, on the face too.
bool touches_with_rim(const Geometry& geometry, EdgeSide side) noexcept {
  return side == EdgeSide::throat || geometry.end.rounded();
}

ContactDepth rim_depth(const Geometry& geometry, const PoseVector& tip) noexcept {
  ContactDepth depth;
  Rim(geometry, tip).set(tip, depth);
  return depth;
}

// The rim of the bore's mouth on the fibre's side.
ContactDepth side_depth(const Geometry& geometry, const ContactSide& side,
                        const PoseVector& tip) noexcept {
  ContactDepth depth;
  if (!(side.past_mouth(tip, geometry.annulus.fibre_radius) > 0)) return depth;
  const double arm = -tip.x;
  const Vector2d e = eccentricity(tip, arm);
  const Radial radial(e, geometry);
  depth.value = radial.eccentricity - geometry.annulus.clearance();
  depth.arm = {arm, -1};
  depth.offset.setZero();
  depth.slope = across(radial.normal);
  depth.curve = radial.curving;
  depth.point = across(e);
  return depth;
}

// Is all of the end at `tip` so far in that what is in the throat stays there? What costs little to
// know, where it is as a rule.
bool far_in(const Geometry& geometry, const PoseVector& tip) noexcept {
  const double ahead = geometry.annulus.fibre_radius *
                       face_slope(geometry, tip).lpNorm<1>();  // at most, of any point
  const double across = tip.e.lpNorm<1>() + geometry.oval.amplitude - geometry.annulus.clearance();
  return geometry.profile.lead_in_length - tip.x - ahead >
         std::max(across, geometry.end.rounding());
}

}  // namespace

EdgeSide side_of(const Geometry& geometry, const PoseVector& tip, EdgeSide before) noexcept {
  if (before == EdgeSide::throat && far_in(geometry, tip)) return EdgeSide::throat;
  const double rho = geometry.end.edge, lever = geometry.annulus.fibre_radius - rho;
  const FaceSupport support(lever, geometry.profile.mouth_radius(), tip.e);
  if (!support.any()) return EdgeSide::throat;
  const double ahead = support.rest(face_slope(geometry, tip)).ahead;
  if (geometry.profile.lead_in_length - tip.x + ahead <= rho) return EdgeSide::face;
  // Deeper than its own radius: in front of a wall, or pressed into the face.
  const EdgeDepth centre = edge_depth(geometry.profile, tip.x + rho, tip.e.norm() + lever);
  return centre.throat() <= 0 ? EdgeSide::throat : before;
}

ContactSide contact_side(const Geometry& geometry, const PoseVector& tip,
                         EdgeSide before) noexcept {
  ContactSide at;
  at.side = side_of(geometry, tip, before);
  const Vector2d out = touches_with_rim(geometry, at.side) ? Rim(geometry, tip).outward() : tip.e;
  if (out.norm() > 0) at.outward = out.normalized();
  const Vector2d at_mouth = eccentricity(tip, -tip.x);
  if (at_mouth.norm() > 0) at.mouth_outward = at_mouth.normalized();
  at.side_ahead =
      geometry.annulus.fibre_radius * at.mouth_outward.dot(geometry.end.cleave) - geometry.end.edge;
  return at;
}

std::array<ContactDepth, kContactPlaces> contact_depths(const Geometry& geometry,
                                                        const ContactSide& side,
                                                        const PoseVector& tip) noexcept {
  return {
      touches_with_rim(geometry, side.side) ? rim_depth(geometry, tip) : face_depth(geometry, tip),
      side_depth(geometry, side, tip)};
}

}  // namespace ferrule
