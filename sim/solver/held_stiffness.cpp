#include "sim/solver/held_stiffness.hpp"

#include "sim/solver/local_model.hpp"

namespace ferrule {

Matrix5 held_stiffness(const World& world, const State& state, double dt) noexcept {
  const Matrix5& holder = world.holder.stiffness;
  const FrozenCoefficients frozen = freeze(world, state, state.command, dt);
  BlockLdl hessian;
  if (hessian.factor(Potential(world, frozen, state.tip).hessian) > 0) return holder;
  return holder - holder * follow_forces(hessian, holder);
}

}  // namespace ferrule
