// What the C headers of all kinds of controllers have in common (controller/c_header.hpp).
#pragma once

#include <functional>
#include <string>

#include "controller/observation.hpp"
#include "controller/policy.hpp"
#include "controller/trained_on.hpp"

namespace ferrule {

// The head of ferrule_command, in lines of at most 100 characters; of a controller that `remembers`
// with the arguments displacement and height.
std::string command_head(bool remembers = false);

// Statements that keep compilers from warning of the arguments that are not `used`.
std::string unused_arguments(const std::function<bool(const ObservationChannel&)>& used);

// The tilts that a controller with so many answers does not command.
std::string no_tilts(int answers = kVelocity);

// What comes before and after the numbers and the functions of one kind of controller.
std::string framed(const std::string& origin, const TrainedOn& trained, const std::string& period,
                   const std::string& body, bool remembers = false);

// An array of constants.
std::string table(const std::string& name, const double* values, std::size_t count);
std::string table(const std::string& name, const float* values, std::size_t count);

}  // namespace ferrule
