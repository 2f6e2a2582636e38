// controller.json: a learned controller of any kind, with all that is needed to run it and to know
// where it came from. controller/README.md describes the keys, data/controller.schema.json states
// them.
#pragma once

#include <string>
#include <variant>

#include "controller/law_file.hpp"
#include "controller/policy_file.hpp"

namespace ferrule {

using ControllerFile = std::variant<LawFile, PolicyFile>;

// Throws FileTrouble, BadInput.
void write_controller(const std::string& file, const ControllerFile& controller);
// Throws FileTrouble, BadInput.
ControllerFile read_controller(const std::string& file);

MakeController maker(const ControllerFile& controller);
const TrainedOn& trained_on(const ControllerFile& controller);

// What makes the controller of `file` for each trial. Throws FileTrouble, BadInput.
MakeController load_controller(const std::string& file);

}  // namespace ferrule
