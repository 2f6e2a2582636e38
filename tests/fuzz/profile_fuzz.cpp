#include "haptic/device_profile.hpp"
#include "sim/base/json_fields.hpp"
#include "tests/fuzz/from.hpp"

namespace ferrule::fuzz {

std::vector<std::string> examples() {
  return {read_text(FERRULE_SOURCE "/data/devices/pen.json")};
}

void read(const std::string& bytes) {
  write_text(folder() + "/profile.json", bytes);
  load_device_profile(folder() + "/profile.json");
}

}  // namespace ferrule::fuzz
