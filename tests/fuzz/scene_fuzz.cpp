#include "sim/scene/scene.hpp"
#include "tests/fuzz/from.hpp"

namespace ferrule::fuzz {

std::vector<std::string> examples() {
  std::vector<std::string> all;
  for (const std::string& name : shipped_scenes())
    all.push_back(load_scene(name).document().dump());
  return all;
}

void read(const std::string& bytes) {
  parse_scene(parse_json(bytes, "fuzz"), "fuzz");
}

}  // namespace ferrule::fuzz
