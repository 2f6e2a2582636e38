// What a step costs and how wrong it is, by method and step size.
#pragma once

#include <string>
#include <vector>

#include "bench/cases.hpp"

namespace ferrule {

struct SteppingRow {
  std::string method, scene_case;
  double step_s;
  double ns_per_step, us_per_simulated_s;
  double tip_error_nm;           // largest over the motion; NaN: diverged
  double force_error_relative;   // of the force at the holder, over the largest reference force
  double newton_iterations = 0;  // per step
  long not_converged = 0;        // steps
  long rejected = 0;             // of steps
};

// Cases: free flight (reference: closed form); insertion through adhesive with contact of end and
// side, corrected laws (reference: CVODE), and with friction (reference: steps of 1 us); vibration
// of an elastic fibre with inertia (CVODE).
std::vector<SteppingRow> bench_stepping(const GoOn& go_on = {});

}  // namespace ferrule
