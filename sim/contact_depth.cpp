#include "sim/contact_depth.hpp"

#include <cmath>

namespace ferrule {
namespace {

// How far the rim of the fibre's end is in bore and cone, each at the point of the rim that is
// deepest there: |e| + r against the bore, and against the cone of half angle beta, as the rim lies
// r (n.t) ahead in the direction n, |e + r tan(beta) t| + r.
struct RimDepths {
  Radial bore, cone;
  EdgeDepth depth;

  RimDepths(const World& world, const PoseVector& tip) noexcept
      : bore(tip.e, world.annulus.clearance()),
        cone(eccentricity(tip, world.annulus.fibre_radius * world.profile.lead_in_tangent),
             world.annulus.clearance()) {
    const double r = world.annulus.fibre_radius;
    const double x_rim = tip.x - r * cone.normal.dot(tip.t);
    depth = edge_depth(world.profile, x_rim, bore.eccentricity + r);
    depth.cone = edge_depth(world.profile, tip.x, cone.eccentricity + r).cone;
  }
};

// The edge between bore and cone: the share of the cone is 0 in the bore, 1 on the cone, and between
// them the derivative of
//   (bore + cone)/2 - w (3 + 6 t^2 - t^4)/16,   t = (bore - cone)/w.
struct RoundedEdge {
  double depth, cone = 0, bend = 0;  // [m], [-], [1/m]

  explicit RoundedEdge(const EdgeDepth& d) noexcept : depth(d.throat()) {
    const double apart = d.bore - d.cone;
    if (apart > 0) cone = 1;
    if (!(std::abs(apart) < kEdgeRounding)) return;
    const double t = apart / kEdgeRounding, t2 = t * t;
    depth = 0.5 * (d.bore + d.cone) - kEdgeRounding * (3 + t2 * (6 - t2)) / 16;
    cone = 0.5 + 0.25 * t * (3 - t2);
    bend = 0.75 * (1 - t2) / kEdgeRounding;
  }
};

// The end on the front face, where it is farthest from the bore.
ContactDepth face_depth(const World& world, const ContactSide& side,
                        const PoseVector& tip) noexcept {
  const double r = world.annulus.fibre_radius;
  const Radial radial(tip.e, world.annulus.clearance());
  const EdgeDepth d =
      edge_depth(world.profile, tip.x - r * side.outward.dot(tip.t), radial.eccentricity + r);
  ContactDepth depth;
  depth.point << tip.x, tip.e + r * radial.normal;
  if (d.throat() <= 0) return depth;
  depth.value = d.face;
  depth.lean = -r * side.outward;
  depth.slope = -Vector3d::UnitX();
  depth.curve.setZero();
  return depth;
}

// The rim of the fibre's end on the bore wall or the cone.
ContactDepth throat_depth(const World& world, const PoseVector& tip) noexcept {
  const double r = world.annulus.fibre_radius, tangent = world.profile.lead_in_tangent;
  const RimDepths rim(world, tip);
  const RoundedEdge edge(rim.depth);
  ContactDepth depth;
  const Vector2d& outward = edge.cone > 0 ? rim.cone.normal : rim.bore.normal;
  depth.point << tip.x, tip.e + r * outward;
  if (rim.depth.face <= 0) return depth;
  const double cosine = 1 / std::sqrt(1 + tangent * tangent), sine = tangent * cosine;
  const double on_cone = edge.cone * cosine, in_bore = 1 - edge.cone;
  depth.value = edge.depth;
  depth.lean = -r * outward;
  depth.slope << -edge.cone * sine, on_cone * rim.cone.normal + in_bore * rim.bore.normal;
  depth.curve = in_bore * rim.bore.curving;
  depth.cone_arm = r * tangent;
  depth.cone_curve = on_cone * rim.cone.curving;
  depth.edge = edge.bend;
  depth.over_edge << sine, rim.bore.normal - cosine * rim.cone.normal;
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
  const double r = world.annulus.fibre_radius;
  const RimDepths rim(world, tip);
  Vector2d out = tip.e;
  EdgeDepth depth = rim.depth;
  if (state.side == EdgeSide::throat)
    out += RoundedEdge(rim.depth).cone * world.profile.lead_in_tangent * r * tip.t;
  if (out.norm() > 0) at.outward = out.normalized();
  if (state.side == EdgeSide::face)
    depth = edge_depth(world.profile, tip.x - r * at.outward.dot(tip.t), tip.e.norm() + r);
  at.side = edge_side(depth, state.side);
  const Vector2d at_mouth = eccentricity(tip, -tip.x);
  if (at_mouth.norm() > 0) at.mouth_outward = at_mouth.normalized();
  return at;
}

std::array<ContactDepth, kContactPlaces> contact_depths(const World& world, const ContactSide& side,
                                                        const PoseVector& tip) noexcept {
  return {side.side == EdgeSide::face ? face_depth(world, side, tip) : throat_depth(world, tip),
          side_depth(world, side, tip)};
}

}  // namespace ferrule
