// controller.json: a controller of any kind, with all that is needed to run it and to know where it
// came from. controller/README.md describes the keys, data/controller.schema.json states them.
#pragma once

#include <string>
#include <variant>

#include "controller/law_file.hpp"
#include "controller/policy_file.hpp"
#include "controller/search_file.hpp"

namespace ferrule {

using ControllerFile = std::variant<LawFile, PolicyFile, SearchFile>;

// The file of a shipped controller by its bare name, where no file of the folder has it; any other
// name as it is.
std::string controller_file(const std::string& name_or_file);

// Throws FileTrouble, BadInput.
void write_controller(const std::string& file, const ControllerFile& controller);
// Of a file, or of a shipped controller by its name. Throws FileTrouble, BadInput.
ControllerFile read_controller(const std::string& name_or_file);

MakeController maker(const ControllerFile& controller);
const TrainedOn& trained_on(const ControllerFile& controller);

// What makes the controller of a file, or a shipped one by its name, for each trial. Throws
// FileTrouble, BadInput.
MakeController load_controller(const std::string& name_or_file);

}  // namespace ferrule
