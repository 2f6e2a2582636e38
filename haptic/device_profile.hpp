// What a force feedback device can do, as far as stability depends on it, with the hand on it.
//
// One JSON file per device (data/devices, described by device.schema.json there); SI inside.
#pragma once

#include <string>

namespace ferrule {

struct DeviceProfile {
  std::string name;
  std::string source;    // where the numbers come from, what is assumed
  double mass;           // moved, at the grip [kg], > 0
  double damping;        // b, viscous, of device and fingers together [N s/m], >= 0
  double coulomb;        // f_c, friction at the grip [N], >= 0
  double resolution;     // Delta, of the position [m], >= 0
  double max_force;      // [N], > 0
  double max_stiffness;  // that the maker says it renders [N/m], > 0
  double period;         // T, of the loop [s], > 0
  int delay_periods;     // d, whole periods from position to force beyond the hold, 0 to 100
};

// `name_or_file`: a file, or the bare name of a profile that ships with the program. Throws
// BadInput, FileTrouble.
DeviceProfile load_device_profile(const std::string& name_or_file);

}  // namespace ferrule
