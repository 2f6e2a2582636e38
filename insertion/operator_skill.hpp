// How skilled a simulated operator is, as the command line and the episodes write it: a skill from
// 0 to 1, then the traits in which he is not as that skill has them (haptic/trainee.hpp),
//   0.8,bore_yield=0.3,tilt_yield=1e-4
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "haptic/trainee.hpp"

namespace ferrule {

class OperatorSkill {
 public:
  OperatorSkill(double skill);  // from 0 to 1
  // Throws BadInput.
  static OperatorSkill parse(const std::string& text);

  const TraineeTraits& traits() const noexcept { return traits_; }
  const std::string& text() const noexcept { return text_; }
  // Of the traits that he has of his own.
  const std::vector<std::string>& own() const noexcept { return own_; }

 private:
  TraineeTraits traits_;
  std::string text_;
  std::vector<std::string> own_;
};

// What a recording calls its operator where he is simulated: "simulated, skill 0.8"; and the skill
// of an operator of that name, empty for any other.
std::string simulated_operator_name(const OperatorSkill& skill);
std::optional<OperatorSkill> simulated_skill(const std::string& name);
// The same of other simulated operators: "WHO, skill 0.8".
std::string operator_name(const std::string& who, const OperatorSkill& skill);
std::optional<OperatorSkill> skill_of(const std::string& who, const std::string& name);

}  // namespace ferrule
