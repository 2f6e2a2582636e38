#include "sim/contact_depth.hpp"

#include <cmath>

namespace ferrule {
namespace {

constexpr double kSmoothing = 1e-3;  // of the clearance

void add_radial(ContactDepth& depth, const Radial& radial, double weight, double arm,
                const Pose& tip, double arm_per_x) noexcept {
  const Vector2d n = weight * radial.normal;
  const Eigen::Matrix2d k = weight * radial.curving;
  const Vector2d by_x = arm_per_x * tip.tail<2>();
  depth.gradient[0] += n.dot(by_x);
  depth.gradient.segment<2>(1) += n;
  depth.gradient.tail<2>() += arm * n;
  depth.hessian.block<2, 2>(1, 1) += k;
  depth.hessian.block<2, 2>(1, 3) += arm * k;
  depth.hessian.block<2, 2>(3, 1) += arm * k;
  depth.hessian.block<2, 2>(3, 3) += arm * arm * k;
  if (arm_per_x == 0) return;
  const Vector2d kx = k * by_x;
  depth.hessian(0, 0) += by_x.dot(kx);
  depth.hessian.block<1, 2>(0, 1) += kx.transpose();
  depth.hessian.block<2, 1>(1, 0) += kx;
  depth.hessian.block<1, 2>(0, 3) += (arm * kx + arm_per_x * n).transpose();
  depth.hessian.block<2, 1>(3, 0) += arm * kx + arm_per_x * n;
}

// The rim of the fibre's end: on the bore wall, the cone or the face.
ContactDepth end_depth(const World& world, const ContactSide& side, const Pose& tip) noexcept {
  const double r = world.annulus.fibre_radius;
  const Radial radial(tip.segment<2>(1), world.annulus.clearance());
  const double x_rim = tip[0] - r * side.outward.dot(tip.tail<2>());
  const EdgeDepth d = edge_depth(world.profile, x_rim, radial.eccentricity + r);

  ContactDepth depth;
  depth.point << tip[0], tip.segment<2>(1) + r * radial.normal;
  if (side.side == EdgeSide::face) {
    if (d.throat() <= 0) return depth;
    depth.value = d.face;
    depth.normal = Vector3d::UnitX();
    depth.gradient << -1, 0, 0, r * side.outward;
    return depth;
  }
  if (d.face <= 0) return depth;
  depth.value = d.throat();
  const bool on_cone = d.cone < d.bore;
  const double tangent = on_cone ? world.profile.lead_in_tangent : 0;
  const double cosine = 1 / std::sqrt(1 + tangent * tangent);
  const double sine = tangent * cosine;
  depth.normal = sine * Vector3d::UnitX() - cosine * across(radial.normal);
  depth.gradient << -sine, 0, 0, sine * r * side.outward;
  add_radial(depth, radial, cosine, 0, tip, 0);
  return depth;
}

// The rim of the bore's mouth on the fibre's side.
ContactDepth side_depth(const World& world, const ContactSide& side, const Pose& tip) noexcept {
  ContactDepth depth;
  if (!side.side_can_touch || tip[0] >= 0) return depth;
  const double arm = -tip[0];
  const Vector2d e = eccentricity(tip, arm);
  const Radial radial(e, world.annulus.clearance());
  depth.value = radial.eccentricity - world.annulus.clearance();
  depth.normal << radial.normal.dot(tip.tail<2>()), -radial.normal;
  depth.point = across(e);
  add_radial(depth, radial, 1, arm, tip, -1);
  return depth;
}

}  // namespace

Radial::Radial(const Vector2d& e, double clearance) noexcept {
  const double smooth = kSmoothing * clearance;
  eccentricity = std::sqrt(e.squaredNorm() + smooth * smooth);
  normal = e / eccentricity;
  curving = (Eigen::Matrix2d::Identity() - normal * normal.transpose()) / eccentricity;
}

ContactSide contact_side(const World& world, const State& state) noexcept {
  ContactSide at;
  const Vector2d e = state.tip.segment<2>(1);
  if (e.norm() > 0) at.outward = e.normalized();
  const double r = world.annulus.fibre_radius;
  const double x_rim = state.tip[0] - r * at.outward.dot(state.tip.tail<2>());
  const EdgeDepth d = edge_depth(world.profile, x_rim, e.norm() + r);
  at.side = edge_side(d, state.side);
  at.side_can_touch = state.tip[0] < 0 && !(at.side == EdgeSide::face && d.inside());
  return at;
}

std::array<ContactDepth, kContactPlaces> contact_depths(const World& world, const ContactSide& side,
                                                        const Pose& tip) noexcept {
  return {end_depth(world, side, tip), side_depth(world, side, tip)};
}

}  // namespace ferrule
