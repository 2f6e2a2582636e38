// Any controller file, whatever method it was learned with.
#pragma once

#include <string>

#include "controller/controller.hpp"

namespace ferrule {

enum class Method { ceres, torch };

// The method that `file` names. Throws FileTrouble, BadInput.
Method controller_method(const std::string& file);

// What makes the controller of `file` for each trial. Throws FileTrouble, BadInput.
MakeController load_controller(const std::string& file);

}  // namespace ferrule
