#include "capture/row.hpp"

namespace ferrule {

RowVector make_row(double time, const HandPose& hand, const StepResult& result) noexcept {
  RowVector row = RowVector::Zero();
  row[kTime.begin] = time;
  row.segment<kPose>(kHandPose.begin) = hand.transpose();
  row.segment<kPose>(kHolder.begin) = result.forces.holder.transpose();
  const auto terms = term_forces(result.forces);
  for (int i = 0; i < kTerms; ++i)
    row.segment<3>(kForces.begin + 3 * i) = terms[static_cast<std::size_t>(i)].transpose();
  row[kStatus.begin] = static_cast<double>(result.status);
  row.segment<kStateSize>(kStates.begin) = to_row(result.state).transpose();
  return row;
}

}  // namespace ferrule
