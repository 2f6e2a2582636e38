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
  info.scene = scene.document().dump();
  info.operator_ = "test";
  info.seed = seed;
  info.trial = trial;
  info.version = program_version();
  info.build = program_build();
  return info;
}

// Trial `trial` of seed 1.
inline TrialSetup setup(const Scene& scene, std::uint64_t trial, std::uint64_t seed = 1) {
  return trial_setup(scene, seed, trial).value();
}
// From that start, with that sensor; ideal unless given.
inline TrialSetup setup(const Scene& scene, const State& start, const ForceSensor& sensor = {}) {
  return {{std::shared_ptr<const Scene>(), &scene}, start, sensor, scene_scaling(scene)};
}
// Trial 1 of seed 1 with an ideal sensor.
inline TrialSetup felt_exactly(const Scene& scene) {
  return setup(scene, draw_start(scene, 1, 1));
}

inline LoopSettings recording_settings(double period = 1e-3, ForceFeedback* feedback = nullptr) {
  return {.period = period, .past_success = true, .feedback = feedback};
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
  r.end = run_insertion(setup(scene, start, sensor), device, recording_settings(),
                        [&](const Tick& tick) {
                          r.rows.push_back(make_row(tick));
                          return true;
                        });
  return r;
}

// Records trial `trial` into `folder`; a simulated operator unless a controller is given.
inline std::string record(const Scene& toleranced, const std::string& folder, std::uint64_t trial,
                          Controller* controller = nullptr, double skill = 0.8) {
  const TrialSetup drawn = feasible_setup(toleranced, 1, trial);
  std::unique_ptr<Device> device;
  if (controller)
    device = std::make_unique<ControllerHand>(recorded_hand(drawn, *controller));
  else
    device = simulated_operator(drawn, skill);
  Recorder recorder(folder, static_cast<int>(trial), info_of(*drawn.scene, 1, trial));
  const InsertionEnd end =
      run_insertion(drawn, *device, recording_settings(), [&](const Tick& tick) {
        recorder.add(make_row(tick));
        return true;
      });
  recorder.info().why = end.why;
  return recorder.finish(end.outcome);
}

}  // namespace ferrule::testing
