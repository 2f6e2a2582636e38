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

}  // namespace

std::vector<std::string> column_names(const Block& block) {
  if (block.width == 1) return {block.name};
  std::vector<std::string> all;
  const auto add = [&](const std::string& prefix, const std::string& names) {
    for (const std::string& name : words(names)) all.push_back(prefix + name);
  };
  if (block.begin == kForces.begin) {
    for (const char* term : kTermNames) add(std::string(term) + "_", block.columns);
  } else if (block.begin == kStates.begin) {
    for_each_field([&](const StateField& field, auto) { add(field.prefix, field.names); });
  } else {
    const std::string text = block.columns;
    add("", text.substr(0, text.find(';')));
  }
  all.resize(static_cast<std::size_t>(block.width));
  return all;
}

std::string about(const Block& block) {
  std::string text = block.columns;
  if (block.begin == kForces.begin) {
    text += " of each of";
    for (int term = 0; term < block.width / 3; ++term)
      text += std::string(" ") + kTermNames[static_cast<std::size_t>(term)];
  } else if (block.begin == kStates.begin) {
    std::size_t columns = 0;
    for_each_field([&](const StateField& field, auto) {
      if (columns < static_cast<std::size_t>(block.width))
        text += (columns ? "; " : "") + std::string(field.about);
      columns += words(field.names).size();
    });
  }
  return text;
}

std::string units(const Block& block) {
  if (block.begin != kStates.begin) return block.unit;
  std::string text;
  for_each_field([&](const StateField& field, auto) { text += std::string(" ") + field.units; });
  return text;
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
