#include "capture/recorder.hpp"
#include "tests/episodes.hpp"
#include "tests/fuzz/from.hpp"

namespace ferrule::fuzz {

std::vector<std::string> examples() {
  const std::string journal = folder() + "/episode_0001.part";
  {
    Recorder recorder(folder(), 1, testing::info_of(load_scene("demo"), 1, 1));
    RowVector row = RowVector::Zero();
    for (int n = 0; n < 3; ++n, row[kTime.begin] = 1e-3 * n) recorder.add(row);
    recorder.flush();
  }
  const std::string bytes = read_text(journal);
  std::filesystem::remove(journal);
  return {bytes};
}

void read(const std::string& bytes) {
  write_text(folder() + "/episode_0001.part", bytes);
  recover(folder());
  for (const auto& entry : std::filesystem::directory_iterator(folder()))
    std::filesystem::remove(entry.path());
}

}  // namespace ferrule::fuzz
