// What steps cost as campaigns take them: under a controller that reads a noisy sensor.
#pragma once

#include <string>
#include <vector>

#include "bench/cases.hpp"

namespace ferrule {

struct CampaignRow {
  std::string scene, controller;
  double step_s;
  long steps;
  double ns_per_step;  // of the simulator's step alone, the commands played again
  double iterations_in_contact;
  double evaluations;  // per step
  long evaluations_max;
  long not_converged, capped;
};

// Every shipped scene, its sensor as shipped, by the admittance tuned by hand; 1000 and 100 times a
// second.
std::vector<CampaignRow> bench_campaigns(const GoOn& go_on = {});

}  // namespace ferrule
