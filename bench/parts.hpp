// What it matters that parts are as they are: success rates with each imperfection on and off.
#pragma once

#include <string>
#include <vector>

#include "bench/cases.hpp"
#include "controller/statistics.hpp"

namespace ferrule {

struct PartRow {
  std::string scene;
  std::string part;        // what the scene has besides; "as shipped": nothing
  std::string controller;  // "constant velocity", "tuned by hand"
  std::size_t trials;      // feasible ones
  std::size_t inserted;
  Interval interval;  // 95 %, Wilson
};

// Each of the scenes as it is, and with: curl of 4 m; an entrance registered to 5 um; the fluid
// ahead of the end (the scene's liquid, or air) in an open and in a blind bore; a cleave of 1
// degree; an edge of 3 um; a bore that is 0.2 um oval; a particle on its wall, one on average, with
// a median of 0.3 um and a spread of 0.8. Straight in at constant velocity and by an admittance
// tuned by hand, the same `trials` of `seed` each.
std::vector<PartRow> bench_parts(std::uint64_t seed, std::size_t trials,
                                 const std::vector<std::string>& scenes, const GoOn& go_on = {});

}  // namespace ferrule
