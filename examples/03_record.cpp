// usage: 03_record FOLDER
// Record demonstrations by a simulated operator, and read one of them again.
#include <cstdio>
#include <filesystem>

#include "capture/recorder.hpp"
#include "capture/replay.hpp"
#include "insertion/simulated_operator.hpp"
#include "sim/scene/draw.hpp"

using namespace ferrule;

// Trial `trial`: the operator pushes the fibre in, feels it, and yields; every tick becomes a row.
std::string record(const Scene& scene, const std::string& folder, int trial) {
  const double period = 1e-3, skill = 0.9;
  const std::uint64_t seed = 1, number = static_cast<std::uint64_t>(trial);
  const State start = draw_start(scene, seed, number);
  const auto hand = simulated_operator(scene, start, skill, period, seed, number);
  EpisodeInfo info;
  info.scene = scene.document.dump();
  info.operator_ = simulated_operator_name(0.9);
  info.seed = seed;
  info.trial = number;
  Recorder recorder(folder, trial, info);
  const InsertionEnd end = record_insertion(scene, start, *hand, recorder);
  std::printf("trial %d: %s after %.1f s, peak force %.2f uN\n", trial, name(end.outcome),
              end.summary.time, 1e6 * end.summary.peak_force);
  return recorder.finish(end.outcome);
}

int main(int argc, char** argv) {
  const std::string folder = argc > 1 ? argv[1] : "episodes";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  const Scene scene = load_scene("demo");
  std::string file;
  for (int trial = 1; trial <= 8; ++trial) file = record(scene, folder, trial);

  const Episode episode = read_episode(file);
  const Eigen::Index last = episode.rows.rows() - 1;
  std::printf("%s: %td rows; the end came to x = %.2f um\n", file.c_str(), last + 1,
              1e6 * episode.rows(last, kStates.begin));
  // The recorded hand drives the simulator through the same states, bit for bit.
  return last > 100 && !verify(episode) ? 0 : 1;
}
