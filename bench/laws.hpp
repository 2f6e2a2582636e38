// What a force law costs and how wrong it is, fidelity by fidelity.
#pragma once

#include <string>
#include <vector>

#include "bench/cases.hpp"

namespace ferrule {

struct LawRow {
  std::string name, fidelity;
  double ns;              // per evaluation, force and slope and potential together
  double relative_error;  // largest over the gaps or depths of the benchmark
};

// Geometry and constants of Table I, roughness 5 nm, gaps of 1 to 450 nm. References: the annulus
// by numerical integration in long double; so the electrostatics of cylinders, from the
// capacitance; the capillary bridge by bisection; Maugis's equations solved in long double; between
// tilted axes (0.2 mrad over 1 mm, from 5 nm) the midpoint rule in 400,000 pieces.
std::vector<LawRow> bench_laws(const GoOn& go_on = {});

}  // namespace ferrule
