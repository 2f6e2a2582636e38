// One demonstration as Fig. 10 of the paper shows one: velocity and forces over time.
#pragma once

#include "app/plot.hpp"
#include "capture/episode.hpp"

namespace ferrule {

// At the tip's scale.
Plot demonstration_plot(const Episode& episode, const Scene& scene);

}  // namespace ferrule
