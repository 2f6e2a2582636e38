// Demonstrations as pairs of observation and velocity, in the hand's world.
#pragma once

#include <string>
#include <vector>

#include "capture/episode.hpp"
#include "controller/observation.hpp"
#include "controller/trained_on.hpp"

namespace ferrule {

// One demonstration, all rows of it.
struct Demonstration {
  std::string file, sha1;  // and the hash of its bytes
  Outcome outcome;
  double period;       // between rows [s]
  double speed_limit;  // of controllers, in the hand's world [m/s]
  std::vector<Observation> observations;
  Eigen::Matrix<double, Eigen::Dynamic, 3> velocity;  // that answers them [m/s]

  Eigen::Index rows() const noexcept { return velocity.rows(); }
  // That of row n, and before the first row that one.
  const Observation& observed(Eigen::Index n) const noexcept {
    return observations[n < 0 ? 0 : static_cast<std::size_t>(n)];
  }
};

struct DemonstrationSet {
  std::vector<Demonstration> demonstrations;  // the successful ones
  std::size_t unsuccessful = 0;               // left out
  std::vector<std::string> scenes;            // names, sorted; more than one where they differ
  std::vector<Json> documents;                // of the scenes that differ
  double speed_scale = 0;  // of the hand: the scene's speed limit, scaled up, largest [m/s]
};

// From the row layout of one episode.
Demonstration demonstration(const Episode& episode, const Scene& scene, const std::string& file);

// All episodes of a folder. Throws FileTrouble, and BadInput if they were recorded with different
// scalings.
DemonstrationSet load_demonstrations(const std::string& folder);

// Throws BadInput if there are fewer successful demonstrations than a fit needs, three.
void refuse_too_few(const DemonstrationSet& set);

// For the file of what was learned from them, sorted by file.
std::vector<TrainedEpisode> trained_episodes(const std::vector<const Demonstration*>& set);

}  // namespace ferrule
