#include "sim/terms/surface.hpp"

#include "sim/terms/printed_well.hpp"

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
