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

// A simulated operator, and what a recording calls him: "simulated, skill 0.8", or "searching, skill
// 0.8" where he finds the bore by touch (controller/searching_operator.hpp).
struct SimulatedOperator {
  OperatorSkill skill;
  bool searches = false;

  std::string name() const;
  // Empty: nobody of that name is simulated.
  static std::optional<SimulatedOperator> named(const std::string& name);
};

}  // namespace ferrule
