#include "sim/analysis/hand_work.hpp"

#include <cmath>

#include "sim/terms/potential.hpp"

namespace ferrule {

double stored_energy(const World& world, const State& state) noexcept {
  const FrozenCoefficients frozen = freeze(world, state, state.command, 0);
  const Potential there(world, frozen, state.tip);
  const Pose deflection = state.tip - state.command - world.holder.sag;
  return there.bore.value + 0.5 * deflection.dot(world.holder.stiffness * deflection) -
         world.holder.weight.dot(state.command);
}

HandWork::HandWork(const World& world, const State& start) noexcept
    : world_(world), stored_(stored_energy(world, start)) {}

void HandWork::move(const State& state, const Pose& to) noexcept {
  const double more = world_.holder.work_of_hand(state.tip, state.command, to);
  work_ += more;
  turned_ += std::abs(more);
}

bool HandWork::gained(const State& end) const noexcept {
  return !(work_ - (stored_energy(world_, end) - stored_) >= -1e-9 * turned_);
}

}  // namespace ferrule
