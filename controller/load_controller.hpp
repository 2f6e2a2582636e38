// Any controller file, whatever method it was learned with.
#pragma once

#include <string>
#include <variant>

#include "controller/controller_file.hpp"
#include "controller/policy_file.hpp"

namespace ferrule {

// The law or the policy of `file`. Throws FileTrouble, BadInput.
std::variant<ControllerFile, PolicyFile> read_law_or_policy(const std::string& file);

// What makes the controller of `file` for each trial. Throws FileTrouble, BadInput.
MakeController load_controller(const std::string& file);

}  // namespace ferrule
