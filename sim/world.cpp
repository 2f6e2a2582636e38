#include "sim/world.hpp"

#include <algorithm>
#include <cmath>

namespace ferrule {

State at_rest(const World& world, const Pose& tip) noexcept {
  State state;
  state.tip = tip;
  state.hand = tip - world.holder.sag;
  const double rho = tip.segment<2>(1).norm() + world.annulus.fibre_radius;
  state.side = edge_side(edge_depth(world.profile, tip[0], rho), EdgeSide::throat);
  return state;
}

double friction_radius(const World& world, double depth, int branch) noexcept {
  if (world.friction->form == Form::printed) return printed_contact_radius(depth);
  if (world.adhesion) return adhesion(*world.adhesion, depth, branch).radius;
  return std::sqrt(std::max(0.0, depth) * world.annulus.fibre_radius);
}

}  // namespace ferrule
