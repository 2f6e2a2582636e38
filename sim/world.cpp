#include "sim/world.hpp"

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

double friction_radius(const World& world, double depth, int branch) noexcept {
  if (std::holds_alternative<printed::Friction>(world.laws.friction))
    return printed::contact_radius(depth);
  if (present(world.laws.adhesion)) return adhesion_force(world.laws, depth, branch).radius;
  const double radius = world.laws.wall ? world.laws.wall->radius : world.annulus.fibre_radius;
  return std::sqrt(std::max(0.0, depth) * radius);
}

AdhesionForce adhesion_force(const Laws& laws, double depth, int branch) noexcept {
  if (const auto* law = std::get_if<Adhesion>(&laws.adhesion)) return adhesion(*law, depth, branch);
  if (const auto* law = std::get_if<printed::Adhesion>(&laws.adhesion))
    return printed::adhesion(*law, depth);
  return {};
}

}  // namespace ferrule
