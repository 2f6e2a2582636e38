#include "bench/recording.hpp"

#include <unistd.h>

#include <chrono>
#include <cmath>
#include <filesystem>

#include "capture/recorder.hpp"
#include "insertion/simulated_operator.hpp"
#include "sim/base/control_period.hpp"
#include "sim/base/measure.hpp"

namespace ferrule {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kRecordingSeed = 1;
constexpr int kRecordings = 3;  // of which the fastest counts

RecordingRow measured_recording(const std::string& name) {
  const Scene scene = load_scene(name);
  const TrialSetup trial = trial_setup(scene, kRecordingSeed, 1).value();
  RecordingRow best{name, 0, kNan, kNan, kNan};
  const std::string folder =
      (fs::temp_directory_path() / ("ferrule-bench-" + std::to_string(::getpid()))).string();
  for (int i = 0; i < kRecordings; ++i) {
    const auto hand = simulated_operator(trial, 0.8);
    Recorder recorder(folder, 1, episode_info(scene, *hand, kRecordingSeed, 1));
    double recorded = 0;
    run_insertion(trial, *hand, {.past_success = true}, [&](const Tick& tick) {
      const double begin = 1e6 * thread_seconds();
      recorder.add(make_row(tick), tick.sample.counts);
      recorded += 1e6 * thread_seconds() - begin;
      return true;
    });
    const auto begin = std::chrono::steady_clock::now();  // a child process writes
    const std::string file = recorder.finish(Outcome::inserted);
    const std::chrono::duration<double, std::micro> written =
        std::chrono::steady_clock::now() - begin;
    const auto rows = static_cast<double>(recorder.rows());
    best.rows = static_cast<long>(recorder.rows());
    best.us_per_row = std::fmin(best.us_per_row, recorded / rows);
    best.us_per_row_written = std::fmin(best.us_per_row_written, written.count() / rows);
    best.kB_per_s = 1e-3 * static_cast<double>(fs::file_size(file)) / (rows * kControlPeriod);
    fs::remove_all(folder);
  }
  return best;
}

}  // namespace

std::vector<RecordingRow> bench_recording(const GoOn& go_on) {
  Cases<RecordingRow> cases;
  for (const char* name : {"bench", "paper"})
    add_case(cases, [=] { return measured_recording(name); });
  return rows_of(cases, go_on);
}

}  // namespace ferrule
