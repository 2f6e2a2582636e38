#include "sim/solver/held_stiffness.hpp"

#include <Eigen/Cholesky>

#include "sim/terms/potential.hpp"

namespace ferrule {

Matrix5 held_stiffness(const World& world, const State& state, double dt) noexcept {
  const Matrix5& holder = world.holder.stiffness;
  const FrozenCoefficients frozen = freeze(world, state, state.command, dt);
  const Eigen::LLT<Matrix5> hessian(Potential(world, frozen, state.tip).hessian.full());
  if (hessian.info() != Eigen::Success) return holder;
  return holder - holder * hessian.solve(holder);
}

}  // namespace ferrule
