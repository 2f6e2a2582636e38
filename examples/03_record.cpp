// usage: 03_record FOLDER
// Record demonstrations by a simulated operator, and read one of them again.
#include <cstdio>
#include <filesystem>

#include "capture/recorder.hpp"
#include "capture/replay.hpp"
#include "insertion/simulated_operator.hpp"

using namespace ferrule;

// Trial `trial`: the operator pushes the fibre in, feels it, and yields; every tick becomes a row.
std::string record(const Scene& scene, const std::string& folder, int trial) {
  const double skill = 0.9;
  const TrialSetup setup = feasible_setup(scene, 1, static_cast<std::uint64_t>(trial));
  const auto hand = simulated_operator(setup, skill);
  EpisodeInfo info;
  info.scene = setup.scene->document().dump();
  info.operator_ = SimulatedOperator{skill}.name();
  info.seed = setup.seed;
  info.trial = setup.trial;
  Recorder recorder(folder, trial, info);
  const InsertionEnd end = record_insertion(setup, *hand, recorder);
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
              1e6 * episode.rows(last, state_column("tip_x")));
  // The recorded hand drives the simulator through the same states, bit for bit.
  return last > 100 && !verify(episode) ? 0 : 1;
}
