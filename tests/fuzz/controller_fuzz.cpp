#include "controller/controller_file.hpp"
#include "tests/fuzz/from.hpp"
#include "tests/policies.hpp"

namespace ferrule::fuzz {

std::vector<std::string> examples() {
  write_controller(folder() + "/policy.json", testing::random_policy_file());
  write_controller(folder() + "/law.json", [] {
    LawFile law;
    for (auto& gain : law.gains) gain.value = 1;
    return law;
  }());
  return {read_text(folder() + "/policy.json"), read_text(folder() + "/law.json")};
}

void read(const std::string& bytes) {
  write_text(folder() + "/fuzz.json", bytes);
  read_controller(folder() + "/fuzz.json");
}

}  // namespace ferrule::fuzz
