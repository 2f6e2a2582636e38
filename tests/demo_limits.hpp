// The limits of a supervisor in the scene `demo`, for tests.
#pragma once

#include "controller/supervisor.hpp"
#include "insertion/scene_scaling.hpp"

namespace ferrule::testing {

inline SupervisorLimits demo_limits() {
  const Scene scene = load_scene("demo");
  return supervisor_limits(scene);
}

}  // namespace ferrule::testing
