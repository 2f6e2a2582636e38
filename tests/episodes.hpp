// Recording episodes for tests.
#pragma once

#include "capture/session.hpp"
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

// Records trial `trial` into `folder`; a simulated operator unless a controller is given.
inline std::string record(const Scene& scene, const std::string& folder, std::uint64_t trial,
                          Controller* controller = nullptr, double skill = 0.8) {
  const State start = draw_start(scene, 1, trial);
  const Scaling scaling = scene_scaling(scene);
  std::unique_ptr<Device> device;
  if (controller)
    device = std::make_unique<ControllerHand>(*controller, scaling.motion_to_hand(start.command),
                                              scaling.motion * scene.limits.speed,
                                              1.1 * scaling.motion * scene.success.depth);
  else
    device = simulated_operator(scene, start, skill, 1e-3, 1, trial);
  Recorder recorder(folder, static_cast<int>(trial), info_of(scene, 1, trial));
  const EpisodeEnd end = run_episode(
      scene, start, *device, ForceSensor(scene.sensor, 1, trial), 1e-3,
      [&](const RowVector& row) { recorder.add(row); }, [] { return false; });
  recorder.info().why = end.why;
  return recorder.finish(end.outcome);
}

}  // namespace ferrule::testing
