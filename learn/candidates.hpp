// Ways to insert, on the same trials: what `ferrule compare` sets side by side.
#pragma once

#include <optional>

#include "controller/campaign.hpp"
#include "learn/demonstrations.hpp"

namespace ferrule {

struct Contestant {
  std::string name;
  MakeController make;         // for trials under the seed it was made for
  std::size_t parameters = 0;  // numbers that were fitted; 0 where nothing was
  double fit_seconds = 0;
  std::optional<double> held_out;  // root mean square error of the velocity, hand's world [m/s]
};

// Those that learn nothing: constant velocity, an admittance tuned by hand, the fastest
// demonstration played again, and the simulated operator of `skill`, each for trials of `scene`
// under `seed`.
std::vector<Contestant> unlearned(const Scene& scene, const DemonstrationSet& set, double skill,
                                  std::uint64_t seed);

// A way to learn from demonstrations: its name on the command line, and in the table.
struct Learner {
  std::string key, name;
  std::function<Contestant(const DemonstrationSet&)> fit;
};
// The parametric laws, a network, five of them, and one with three rounds of DAgger. Those that
// need libtorch throw BadInput where it is missing.
std::vector<Learner> learners(std::uint64_t fit_seed);

// The first `count` demonstrations of a set.
DemonstrationSet first_of(const DemonstrationSet& set, std::size_t count);

// Time of one action [ns], over the observations of a demonstration.
double ns_per_action(const Contestant& contestant, const Demonstration& felt);

}  // namespace ferrule
