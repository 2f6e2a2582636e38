// What one command of a controller costs and how wrong its arithmetic is.
#pragma once

#include <string>
#include <vector>

#include "bench/cases.hpp"

namespace ferrule {

struct ControllerRow {
  std::string name, shape;
  double ns;              // per command
  double relative_error;  // largest over 1000 states, of the largest velocity; 0 if it is in double
};

// The insertion law, and policies with three samples of the past and weights that are drawn,
// against the same networks in double precision.
std::vector<ControllerRow> bench_controllers(const GoOn& go_on = {});

}  // namespace ferrule
