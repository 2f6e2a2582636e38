#include "sim/model/world.hpp"

#include <algorithm>
#include <cmath>

namespace ferrule {

State at_rest(const World& world, const Pose& tip) noexcept {
  State state;
  state.tip = tip;
  state.command = tip - world.holder.sag;
  const double rho = tip.segment<2>(1).norm() + world.annulus.fibre_radius;
  state.side = edge_side(edge_depth(world.profile, tip[0], rho), EdgeSide::throat);
  return state;
}

ContactRadius friction_radius(const World& world, double depth,
                              const AdhesionForce& pull) noexcept {
  if (std::holds_alternative<printed::Friction>(world.laws.friction))
    return {printed::contact_radius(depth), printed::contact_radius_slope(depth)};
  if (present(world.laws.adhesion)) return {pull.radius, pull.radius_slope};
  const double curvature = world.laws.wall ? world.laws.wall->radius : world.annulus.fibre_radius;
  const double radius = std::sqrt(std::max(0.0, depth) * curvature);
  return {radius, radius > 0 ? 0.5 * curvature / radius : 0};
}

ContactRadius friction_radius(const World& world, double depth, int branch) noexcept {
  const bool prescribed = std::holds_alternative<printed::Friction>(world.laws.friction);
  return friction_radius(world, depth,
                         prescribed ? AdhesionForce{} : adhesion_force(world.laws, depth, branch));
}

AdhesionForce adhesion_force(const Laws& laws, double depth, int branch) noexcept {
  if (const auto* law = std::get_if<Adhesion>(&laws.adhesion)) return adhesion(*law, depth, branch);
  if (const auto* law = std::get_if<printed::Adhesion>(&laws.adhesion))
    return printed::adhesion(*law, depth);
  return {};
}

}  // namespace ferrule
