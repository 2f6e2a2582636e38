// Rows of demonstrations as a fit sees them, and which demonstrations it sees.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "learn/demonstrations.hpp"

namespace ferrule {

inline constexpr double kStep = 0.01;  // between rows used [s]

// One row as a fit sees it.
struct Sample {
  Eigen::Vector3d force, velocity;
  double depth, time;
};
using Samples = std::vector<Sample>;

// Was the velocity of row n cut to the speed limit? A recorded controller's is; it says nothing of
// what was meant.
bool cut_to_limit(const Demonstration& d, Eigen::Index n) noexcept;

// Rows of a demonstration every 10 ms, but for those cut to the speed limit, with the force of
// `reaction` seconds before.
Samples samples(const Demonstration& d, double reaction);

// The operator's delay, up to 0.4 s [s]: that between force and lateral velocity which leaves the
// least of the velocity unexplained by a regression on force, depth and a constant.
double reaction_time(const std::vector<const Demonstration*>& set);

// (training, held out): about a fifth, one at least, is held out, drawn by `seed`.
std::pair<std::vector<const Demonstration*>, std::vector<const Demonstration*>> split(
    const std::vector<Demonstration>& all, std::uint64_t seed);

}  // namespace ferrule
