// Whether planning for the success rate pays: campaigns of the full model beside those of the scene
// as shipped and as planned.
#pragma once

#include <string>
#include <vector>

#include "bench/cases.hpp"
#include "controller/statistics.hpp"
#include "sim/analysis/plan.hpp"

namespace ferrule {

struct PlanRow {
  std::string scene;
  double planning_s;   // of the processor
  double error_bound;  // the plan's
  double sampled_twice;
  // Of a campaign on one core, sensor, controller and all, in turns; the least of each [us of the
  // processor].
  double full_us_per_simulated_s, shipped_us_per_simulated_s, planned_us_per_simulated_s;
  double ratio;  // full over planned
  std::size_t trials;
  std::size_t full_inserted, planned_inserted;  // by the admittance tuned by hand, the same starts
  Interval full_interval, planned_interval;     // 95 %, Wilson
};

// Each scene, planned for a tolerance of 0.01 of the success rate, and `trials` trials of `seed`. The full model is the scene in the finest fidelity (16 nodes), every step
// solved.
std::vector<PlanRow> bench_plans(std::uint64_t seed, std::size_t trials,
                                 const std::vector<std::string>& scenes, const GoOn& go_on = {});

}  // namespace ferrule
