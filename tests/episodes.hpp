// Recording episodes for tests.
#pragma once

#include "capture/recorder.hpp"
#include "controller/trial.hpp"
#include "insertion/scene_scaling.hpp"
#include "insertion/simulated_operator.hpp"
#include "sim/scene/draw.hpp"

namespace ferrule::testing {

inline EpisodeInfo info_of(const Scene& scene, std::uint64_t seed, std::uint64_t trial) {
  EpisodeInfo info;
  info.scene = scene.document.dump();
  info.operator_ = "test";
  info.seed = seed;
  info.trial = trial;
  info.version = program_version();
  info.build = program_build();
  return info;
}

inline LoopSettings recording_settings(const Scene& scene, double period = 1e-3,
                                       ForceFeedback* feedback = nullptr) {
  return {.scaling = scene_scaling(scene),
          .period = period,
          .past_success = true,
          .feedback = feedback};
}

// What a recording has of an insertion.
struct RecordedRows {
  InsertionEnd end;
  std::vector<RowVector> rows;

  Rows matrix() const {
    Rows all(static_cast<Eigen::Index>(rows.size()), kRowSize);
    for (std::size_t n = 0; n < rows.size(); ++n) all.row(static_cast<Eigen::Index>(n)) = rows[n];
    return all;
  }
};
inline RecordedRows record_rows(const Scene& scene, const State& start, Device& device,
                                const ForceSensor& sensor = {}) {
  RecordedRows r;
  r.end =
      run_insertion(scene, start, device, sensor, recording_settings(scene), [&](const Tick& tick) {
        r.rows.push_back(make_row(tick));
        return true;
      });
  return r;
}

// Records trial `trial` into `folder`; a simulated operator unless a controller is given.
inline std::string record(const Scene& toleranced, const std::string& folder, std::uint64_t trial,
                          Controller* controller = nullptr, double skill = 0.8) {
  const FeasibleTrial drawn = feasible_trial(toleranced, 1, trial);
  const Scene& scene = *drawn.scene;
  const State start = draw_start(scene, 1, trial);
  std::unique_ptr<Device> device;
  if (controller)
    device = std::make_unique<ControllerHand>(recorded_hand(scene, start, *controller));
  else
    device = simulated_operator(scene, start, skill, 1e-3, 1, trial);
  Recorder recorder(folder, static_cast<int>(trial), info_of(scene, 1, trial));
  const InsertionEnd end = run_insertion(scene, start, *device, ForceSensor(scene.sensor, 1, trial),
                                         recording_settings(scene), [&](const Tick& tick) {
                                           recorder.add(make_row(tick));
                                           return true;
                                         });
  recorder.info().why = end.why;
  return recorder.finish(end.outcome);
}

}  // namespace ferrule::testing
