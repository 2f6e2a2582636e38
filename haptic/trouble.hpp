// What can be wrong with a device.
#pragma once

#include <stdexcept>

namespace ferrule {

// A device that is not there, may not be opened, or does not behave: what() is one line that names
// it and says what is wrong. The program ends with exit code 4.
struct DeviceTrouble : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace ferrule
