// What a term of the forces costs in a planned scene.
#pragma once

#include "sim/analysis/plan.hpp"

namespace ferrule {

// What `term` of `plan` for `scene` adds to what a smooth step needs, to prepare the potential and
// evaluate it once, where the term is strongest [ns], >= 0.
double term_cost(const Plan& plan, const Scene& scene, const PlannedTerm& term);

}  // namespace ferrule
