#include "controller/safetensors.hpp"
#include "tests/fuzz/from.hpp"

namespace ferrule::fuzz {

std::vector<std::string> examples() {
  return {
      safetensors_bytes({{"a", {{2, 3}, {1, 2, 3, 4, 5, 6}}}, {"b", {{1}, {7}}}}, {{"k", "v"}})};
}

void read(const std::string& bytes) {
  parse_safetensors(bytes, "fuzz");
}

}  // namespace ferrule::fuzz
