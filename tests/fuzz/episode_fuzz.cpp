#include "capture/episode.hpp"
#include "capture/recorder.hpp"
#include "capture/replay.hpp"
#include "tests/episodes.hpp"
#include "tests/fuzz/from.hpp"

namespace ferrule::fuzz {

std::vector<std::string> examples() {
  Episode episode;
  episode.info = testing::info_of(load_scene("demo"), 1, 1);
  episode.rows = Rows::Zero(3, kRowSize);
  episode.rows.col(kTime.begin) << 0, 1e-3, 2e-3;
  write_episode(folder() + "/example.h5", episode);
  const std::string bytes = read_text(folder() + "/example.h5");
  std::filesystem::remove(folder() + "/example.h5");
  return {bytes};
}

void read(const std::string& bytes) {
  const std::string file = folder() + "/fuzz.h5";
  write_text(file, bytes);
  const Episode episode = read_episode(file);
  verify(episode);
  file_difference(file);
}

}  // namespace ferrule::fuzz
