// What breaks if a numerical parameter of the solver is halved or doubled
// (sim/model/solver_parameters.hpp).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bench/cases.hpp"

namespace ferrule {

struct ParameterRow {
  std::string parameter;  // "none": all as they are
  double value = 0, factor = 1;
  long steps = 0, not_converged = 0, iteration_limit = 0;
  double evaluations = 0;  // of the potential, per step
  int evaluations_max = 0;
  // How far a step ends from a strict one from the same state: none extrapolated, force tolerance
  // 1e-12, every Newton step evaluated. Of 99 % of the steps, and the largest [clearances].
  double error_p99 = 0, error_max = 0;
};

// Each parameter halved and doubled, along motions in the given scenes from `starts` starts each,
// in steps of 1 ms, drawn under `seed`.
std::vector<ParameterRow> bench_parameters(std::uint64_t seed, std::size_t starts,
                                           const std::vector<std::string>& scenes,
                                           const GoOn& go_on = {});

}  // namespace ferrule
