#include "capture/row.hpp"

namespace ferrule {

RowVector make_row(const Tick& tick) noexcept {
  const StepResult& result = tick.result;
  RowVector row = RowVector::Zero();
  row[kTime.begin] = tick.time;
  row.segment<kPose>(kHandPose.begin) = tick.hand.transpose();
  row.segment<kPose>(kHandVelocity.begin) = tick.velocity.transpose();
  row.segment<kPose>(kCommand.begin) = tick.command.transpose();
  row.segment<kPose>(kHolder.begin) = result.forces.holder.transpose();
  const auto terms = term_forces(result.forces);
  for (int i = 0; i < kTerms; ++i)
    row.segment<3>(kForces.begin + 3 * i) = terms[static_cast<std::size_t>(i)].transpose();
  row[kStatus.begin] = static_cast<double>(result.status);
  row.segment<kStateSize>(kStates.begin) = to_row(result.state).transpose();
  return row;
}

}  // namespace ferrule
