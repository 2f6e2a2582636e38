// Scenes for tests.
#pragma once

#include "sim/scene/scene.hpp"

namespace ferrule::testing {

inline constexpr double kFibreRadius = 62.5e-6;  // [m] of all shipped scenes

// Setting of a scene whose every step is solved, none followed along a tangent.
inline constexpr const char* kEveryStepSolved = R"(tangent={"tip_nm":0,"force_uN":0})";

inline Scene paper(const std::vector<std::string>& settings = {}) {
  return load_scene("paper", settings);
}

// An insertion of some 20 um.
inline Scene quick(std::vector<std::string> settings = {}) {
  for (const char* s : {"start.distance_um=10", "success.depth_um=8", "limits.speed_um_s=20"})
    settings.emplace_back(s);
  return paper(settings);
}

inline Pose pose(double x, double y, double z, double tilt_y = 0, double tilt_z = 0) {
  Pose p;
  p << x, y, z, tilt_y, tilt_z;
  return p;
}

// No forces but the walls: a rigid fibre in a sharp-edged bore.
inline Scene bare(std::vector<std::string> settings = {}) {
  settings.insert(settings.begin(), {"laws={}", "ferrule.lead_in=null"});
  return load_scene("paper", settings);
}

}  // namespace ferrule::testing
