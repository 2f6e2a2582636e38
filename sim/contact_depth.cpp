#include "sim/contact_depth.hpp"

#include <cmath>

namespace ferrule {
namespace {

// The rim of the fibre's end: on the bore wall, the cone or the face.
ContactDepth end_depth(const World& world, const ContactSide& side,
                       const PoseVector& tip) noexcept {
  const double r = world.annulus.fibre_radius;
  const Radial radial(tip.e, world.annulus.clearance());
  const double x_rim = tip.x - r * side.outward.dot(tip.t);
  const EdgeDepth d = edge_depth(world.profile, x_rim, radial.eccentricity + r);

  ContactDepth depth;
  depth.point << tip.x, tip.e + r * radial.normal;
  if (side.side == EdgeSide::face) {
    if (d.throat() <= 0) return depth;
    depth.value = d.face;
    depth.lean = -r * side.outward;
    depth.slope = -Vector3d::UnitX();
    depth.curve.setZero();
    return depth;
  }
  if (d.face <= 0) return depth;
  depth.lean = -r * side.outward;
  const double tangent = world.profile.lead_in_tangent, apart = d.bore - d.cone;
  const double cosine = 1 / std::sqrt(1 + tangent * tangent), sine = tangent * cosine;
  // The share of the cone: 0 in the bore, 1 on the cone, between them the derivative of
  // (bore + cone)/2 - w (3 + 6 t^2 - t^4)/16, t = (bore - cone)/w.
  double cone = apart > 0 ? 1 : 0;
  depth.value = d.throat();
  if (std::abs(apart) < kEdgeRounding) {
    const double t = apart / kEdgeRounding, t2 = t * t;
    depth.value = 0.5 * (d.bore + d.cone) - kEdgeRounding * (3 + t2 * (6 - t2)) / 16;
    cone = 0.5 + 0.25 * t * (3 - t2);
    depth.edge = 0.75 * (1 - t2) / kEdgeRounding;
    depth.over_edge << sine, (1 - cosine) * radial.normal;
  }
  const double radially = cone * cosine + (1 - cone);
  depth.slope << -cone * sine, radially * radial.normal;
  depth.curve = radially * radial.curving;
  return depth;
}

// The rim of the bore's mouth on the fibre's side.
ContactDepth side_depth(const World& world, const ContactSide& side,
                        const PoseVector& tip) noexcept {
  ContactDepth depth;
  if (!(side.past_mouth(tip, world.annulus.fibre_radius) > 0)) return depth;
  const double arm = -tip.x;
  const Vector2d e = eccentricity(tip, arm);
  const Radial radial(e, world.annulus.clearance());
  depth.value = radial.eccentricity - world.annulus.clearance();
  depth.arm = {arm, -1};
  depth.lean.setZero();
  depth.slope = across(radial.normal);
  depth.curve = radial.curving;
  depth.point = across(e);
  return depth;
}

}  // namespace

ContactSide contact_side(const World& world, const State& state) noexcept {
  ContactSide at;
  const PoseVector tip(state.tip);
  const Vector2d e = tip.e;
  if (e.norm() > 0) at.outward = e.normalized();
  const Vector2d at_mouth = eccentricity(tip, -tip.x);
  if (at_mouth.norm() > 0) at.mouth_outward = at_mouth.normalized();
  const double r = world.annulus.fibre_radius;
  const double x_rim = tip.x - r * at.outward.dot(tip.t);
  const EdgeDepth d = edge_depth(world.profile, x_rim, e.norm() + r);
  at.side = edge_side(d, state.side);
  return at;
}

std::array<ContactDepth, kContactPlaces> contact_depths(const World& world, const ContactSide& side,
                                                        const PoseVector& tip) noexcept {
  return {end_depth(world, side, tip), side_depth(world, side, tip)};
}

}  // namespace ferrule
