// A controller as one C header, for a machine's own controller: C99, no dependencies but the C
// library, no allocation. It has the same functions for every kind of controller:
//
//   void ferrule_start(ferrule_state* s);           before the start
//   void ferrule_command(ferrule_state* s, const double wrench[5], double depth, double time,
//                        double velocity[5]);       once per period
//
// with the arguments of Controller::command, in the hand's world and SI units: the wrench, then the
// scalars of kObservation (controller/observation.hpp). A search, and a policy with a memory, also
// take, before the velocity, `const double displacement[5], double height`.
#pragma once

#include <string>

#include "controller/controller_file.hpp"

namespace ferrule {

// `origin` stands in the header's first comment.
std::string c_header(const LawFile& law, const std::string& origin);
std::string c_header(const PolicyFile& policy, const std::string& origin);
std::string c_header(const ControllerFile& controller, const std::string& origin);

}  // namespace ferrule
