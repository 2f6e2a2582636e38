#include "capture/row.hpp"

#include <sstream>

namespace ferrule {
namespace {

std::vector<std::string> words(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> all;
  for (std::string word; in >> word;) all.push_back(word);
  return all;
}

std::vector<std::string> prefixed(const std::string& prefix, const std::string& names) {
  std::vector<std::string> all = words(names);
  for (std::string& name : all) name.insert(0, prefix);
  return all;
}

constexpr const char* kPoseNames = "x y z tilt_y tilt_z";

std::vector<std::string> state_names() {
  std::vector<std::string> all;
  const auto add = [&](const std::string& prefix, const std::string& names) {
    for (std::string& name : prefixed(prefix, names)) all.push_back(std::move(name));
  };
  add("tip_", kPoseNames);
  add("hand_", kPoseNames);
  add("", "time on_face bridge");
  for (const char* place : {"end_", "side_"})
    add(place, "closed depth stuck_x stuck_y stuck_z branch");
  for (const char* part : {"velocity_", "tip_before_", "velocity_before_"}) add(part, kPoseNames);
  add("", "period_before air");
  return all;
}

}  // namespace

std::vector<std::string> column_names(const Block& block) {
  if (block.begin == kStates.begin) return state_names();
  if (block.width == 1) return {block.name};
  if (block.begin != kForces.begin) {
    const std::string text = block.columns;
    return words(text.substr(0, text.find(';')));
  }
  std::vector<std::string> all;
  for (const char* term : kTermNames)
    for (const std::string& name : prefixed(std::string(term) + "_", "x y z")) all.push_back(name);
  all.resize(static_cast<std::size_t>(block.width));
  return all;
}

RowVector make_row(const Tick& tick) noexcept {
  const StepResult& result = tick.result;
  RowVector row = RowVector::Zero();
  row[kTime.begin] = tick.time;
  row.segment<kPose>(kHandPose.begin) = tick.hand.transpose();
  row.segment<kPose>(kHandVelocity.begin) = tick.velocity.transpose();
  row.segment<kPose>(kCommand.begin) = tick.command.transpose();
  row.segment<kPose>(kHolder.begin) = result.holder.transpose();
  for (const Term term : kAllTerms)
    row.segment<3>(force_column(term)) = tick.forces.force(term).transpose();
  row[kStatus.begin] = static_cast<double>(result.status);
  row.segment<kStateSize>(kStates.begin) = to_row(result.state).transpose();
  return row;
}

RecordedStep step_of(const RowVector& row) noexcept {
  RecordedStep step{StepResult(state_of(row.segment<kStateSize>(kStates.begin).transpose())), {}};
  step.result.holder = step.forces.holder = block(row, kHolder).transpose();
  step.result.status = static_cast<StepStatus>(static_cast<int>(row[kStatus.begin]));
  for (const Term term : kAllTerms)
    step.forces[term][0].force = row.segment<3>(force_column(term)).transpose();
  return step;
}

}  // namespace ferrule
