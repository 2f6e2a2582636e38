#include "sim/world.hpp"

namespace ferrule {

State at_rest(const World& world, const Pose& tip) noexcept {
  State state;
  state.tip = state.hand = tip;
  if (world.gravity) state.hand[1] += gravity(*world.gravity, world.fibre) / world.holder.stiffness;
  const double rho = tip.segment<2>(1).norm() + world.annulus.fibre_radius;
  state.side = edge_side(edge_depth(world.profile, tip[0], rho), EdgeSide::throat);
  return state;
}

}  // namespace ferrule
