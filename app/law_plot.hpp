// A fitted law over the demonstrations it was fitted to.
#pragma once

#include "app/plot.hpp"
#include "controller/law_file.hpp"
#include "learn/demonstrations.hpp"

namespace ferrule {

// In the hand's world: lateral velocities against force, velocity along x against depth, and over
// time in one demonstration. Data as points, the law as lines.
Plot law_plot(const DemonstrationSet& set, const LawFile& controller);

}  // namespace ferrule
