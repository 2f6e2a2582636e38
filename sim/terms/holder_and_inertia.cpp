#include "sim/terms/holder_and_inertia.hpp"

namespace ferrule {

void HolderTerm::add(const World&, const FrozenCoefficients& frozen, const PoseVector& tip,
                     Energy& total) noexcept {
  const PoseVector move = tip - frozen.from;
  const PoseVector pull = frozen.stiffness.times(move);
  const double sprung = 0.5 * move.dot(pull), loaded = frozen.load.dot(move);
  total.value += sprung - loaded;
  total.value_scale += sprung + std::abs(loaded);
  total.force_scale += pull.length() + frozen.load_scale;
  total.gradient += pull;
  total.gradient -= frozen.load;
  total.hessian += frozen.stiffness;
}

void HolderTerm::report(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                        const Potential&, Breakdown& b) noexcept {
  b.holder = PoseMatrix(world.holder.stiffness).times(tip - frozen.command).full();
  if (frozen.damping_rate > 0)
    b.holder += world.holder.damping *
                (frozen.damping_rate * (tip - frozen.from) - frozen.damping_drift).full();
  b[Term::gravity][0] = {{0, world.holder.weight[1], 0}, tip.position() + world.holder.weight_arm};
}

}  // namespace ferrule
