// A verb that is a library of its own (app/CMakeLists.txt), loaded when it is chosen: a clone does not
// compile it for other verbs.
#pragma once

#include "app/verbs.hpp"

namespace ferrule {

// Adds the options of a verb, and sets what it does. The library of each has one:
//   extern "C" const AddOptions ferrule_loaded_verb;
using AddOptions = void (*)(CLI::App& verb, Run& run);

// Throws BadInput, when the verb is chosen, where it was not built.
void add_loaded_verb(CLI::App& app, Run& run, const std::string& name,
                     const std::string& description);

}  // namespace ferrule
