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
  for (const Term term : kAllTerms)
    row.segment<3>(force_column(term)) = result.forces.force(term).transpose();
  row[kStatus.begin] = static_cast<double>(result.status);
  row.segment<kStateSize>(kStates.begin) = to_row(result.state).transpose();
  return row;
}

StepResult step_of(const RowVector& row) noexcept {
  StepResult result(state_of(block(row, kStates).transpose()));
  result.forces.holder = block(row, kHolder).transpose();
  for (const Term term : kAllTerms)
    result.forces[term][0].force = row.segment<3>(force_column(term)).transpose();
  result.status = static_cast<StepStatus>(static_cast<int>(row[kStatus.begin]));
  return result;
}

}  // namespace ferrule
