// The rows of demonstrations as a fit sees them.
#pragma once

#include <vector>

#include "learn/demonstrations.hpp"

namespace ferrule {

struct Sample {
  Eigen::Vector3d force, velocity;  // felt, relative to that at rest [N]; that answers it [m/s]
  double depth, time;               // [m], [s]
};
using Samples = std::vector<Sample>;  // of one episode

// Rows of a demonstration every 10 ms, with the force of `reaction` [s] before. Rows at exactly the
// speed limit were cut to it (a recorded controller's are) and say nothing of the law.
Samples samples(const Demonstration& demonstration, double reaction);

// Every `stride`-th of them.
Samples thinned(const Samples& samples, std::size_t stride);

// The delay [s] between force and lateral velocity, up to 0.4 s in steps of 10 ms, that leaves the
// least unexplained.
double reaction_time(const std::vector<const Demonstration*>& demonstrations);

// Throws BadInput if there are fewer than 300 rows, lateral forces that hardly change, or a hand
// that never moves or never goes in.
void refuse_uninformative(const std::vector<Samples>& episodes);

}  // namespace ferrule
