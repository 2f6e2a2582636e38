#include "sim/solver/held_stiffness.hpp"

#include "sim/solver/local_model.hpp"

namespace ferrule {

Matrix5 held_stiffness(const World& world, const State& state, double dt) noexcept {
  const Matrix5& holder = world.holder.stiffness;
  const FrozenCoefficients frozen = freeze(world, state, state.command, dt);
  BlockLdl hessian;
  if (hessian.factor(Potential(world, frozen, state.tip).hessian) > 0) return holder;
  Matrix5 follows;  // what the end moves by as the hand does
  for (int k = 0; k < 5; ++k)
    follows.col(k) = -hessian.solve(PoseVector(Pose(holder.col(k)))).full();
  return holder - holder * follows;
}

}  // namespace ferrule
