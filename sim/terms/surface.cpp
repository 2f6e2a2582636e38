#include "sim/terms/surface.hpp"

#include <algorithm>
#include <cmath>

namespace ferrule {
namespace {

PoseVector by_tip(const World& world, PoseVector gradient) noexcept {
  gradient.t += world.end.behind * gradient.e;
  return world.oval.by_pose(gradient);
}
PoseMatrix by_tip(const World& world, PoseMatrix m) noexcept {
  const double arm = world.end.behind;
  m.tt += arm * (m.et + m.et.transpose() + arm * m.ee);
  m.et += arm * m.ee;
  m.xt += arm * m.xe;
  return world.oval.by_pose(m);
}

}  // namespace

PoseVector whole(const World& world, const PoseVector& tip) noexcept {
  PoseVector at = world.oval.stretched(tip);
  at.x += world.end.behind;
  at.e += world.end.behind * at.t;
  return at;
}

double printed_length(const World& world, const FrozenCoefficients& frozen) noexcept {
  return std::max(0.0, frozen.length - world.end.behind);
}

double printed_arm(const World& world, const FrozenCoefficients& frozen) noexcept {
  const double length = printed_length(world, frozen);
  const bool acts = frozen.contact.side == EdgeSide::throat && length > 0;
  return acts && has_printed_forces(world) ? world.end.behind + 0.5 * length : 0;
}

double printed_gap(const World& world, const FrozenCoefficients& frozen,
                   const PoseVector& tip) noexcept {
  const double arm = printed_arm(world, frozen);
  if (arm == 0) return INFINITY;
  return world.annulus.clearance() - eccentricity(world.oval.stretched(tip), arm).norm();
}

void SurfaceForcesTerm::add(const World& world, const FrozenCoefficients& frozen,
                            const PoseVector& tip, Potential& potential) noexcept {
  if (frozen.contact.side != EdgeSide::throat) return;
  const double length = printed_length(world, frozen);
  Energy& bore = potential.bore;
  if (world.oval.round() && world.end.behind == 0) {
    add_surface_forces(bore, potential.surface, world, length, frozen.bridge, tip);
    return;
  }
  Energy there;
  SurfaceGradients terms;
  add_surface_forces(there, terms, world, length, frozen.bridge, whole(world, tip));
  bore.value += there.value;
  bore.value_scale += there.value_scale;
  bore.force_scale += there.force_scale;
  bore.gradient += by_tip(world, there.gradient);
  bore.hessian += by_tip(world, there.hessian);
  for (std::size_t i = 0; i < kSurfaceTerms; ++i) potential.surface[i] += by_tip(world, terms[i]);
}

void SurfaceForcesTerm::report(const World&, const FrozenCoefficients&, const PoseVector& tip,
                               const Potential& potential, Breakdown& b) noexcept {
  const Vector3d end = tip.position();
  const double length = -tip.x, inverse = 1 / length;
  for (std::size_t i = 0; i < kSurfaceTerms && length > 0; ++i) {
    const PoseVector& g = potential.surface[i];
    const Vector2d mouth = -inverse * g.t;
    const Vector2d inside = -g.e - mouth;
    TermForces& term = b[kSurfaceTermTable[i]];
    term[0] = {{-g.x, inside.x(), inside.y()}, end};
    term[1] = {across(mouth), end + Vector3d(length, length * tip.t.x(), length * tip.t.y())};
  }
}

}  // namespace ferrule
