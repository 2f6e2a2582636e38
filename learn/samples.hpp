// The rows of demonstrations as a fit sees them.
#pragma once

#include <cstdint>
#include <vector>

#include "learn/demonstrations.hpp"

namespace ferrule {

inline constexpr std::size_t kFewestRows = 300;  // that a fit needs

// What was observed, the wrench of one reaction time before, and the motion that answers it.
struct Sample : Observation {
  Eigen::Vector3d velocity;                             // [m/s]
  Eigen::Vector2d tilt_rate = Eigen::Vector2d::Zero();  // about y and z [rad/s]
};
using Samples = std::vector<Sample>;  // of one episode

// Was the velocity of row n cut to the speed limit? A recorded controller's is; it says nothing of
// what was meant.
bool cut_to_limit(const Demonstration& demonstration, Eigen::Index n) noexcept;

// Rows of a demonstration every 10 ms, but for those cut to the speed limit, with the wrench of
// `reaction` [s] before.
Samples samples(const Demonstration& demonstration, double reaction);

// Every `stride`-th of them.
Samples thinned(const Samples& samples, std::size_t stride);

// About a fifth, one at least, is held out for testing, drawn by `seed`.
struct Split {
  std::vector<const Demonstration*> training, testing;
};
Split split(const std::vector<Demonstration>& all, std::uint64_t seed);

// The delay [s] between force and lateral velocity, up to 0.4 s in steps of 10 ms, that leaves the
// least unexplained.
double reaction_time(const std::vector<const Demonstration*>& demonstrations);

// Throws BadInput if there are fewer than 300 rows, lateral forces that hardly change, or a hand
// that never moves or never goes in.
void refuse_uninformative(const std::vector<Samples>& episodes);

}  // namespace ferrule
