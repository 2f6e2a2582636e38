// Demonstrations as pairs of observation and velocity, in the hand's world.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "capture/episode_copies.hpp"
#include "controller/observation.hpp"
#include "controller/trained_on.hpp"

namespace ferrule {

inline constexpr double kStep = 0.01;  // between the rows that are learned from [s]
// Every how manieth row that is, of those `period` [s] apart.
Eigen::Index rows_per_step(double period) noexcept;

// What a demonstrator was at from a moment on (the episode's `phases`).
struct DemonstratedPhase {
  std::string name;
  double begin;              // since the start [s]
  Observation before, then;  // of the tick before, and of that moment
};

// One demonstration, in rows of kStep.
struct Demonstration {
  std::string file, sha1;  // and the hash of its bytes
  std::string operator_;
  std::uint64_t seed = 0, trial = 0;  // of its start and of the operator's chance
  Outcome outcome;
  double period;       // between rows [s]
  double speed_limit;  // of controllers, in the hand's world [m/s]
  std::vector<Observation> observations;
  Eigen::Matrix<double, Eigen::Dynamic, 3> velocity;    // that answers them [m/s]
  Eigen::Matrix<double, Eigen::Dynamic, 2> tilt_rates;  // and the rates of tilt [rad/s]
  std::vector<DemonstratedPhase> phases{};              // where the demonstrator told them

  Eigen::Index rows() const noexcept { return velocity.rows(); }
  // That of row n, and before the first row that one.
  const Observation& observed(Eigen::Index n) const noexcept {
    return observations[n < 0 ? 0 : static_cast<std::size_t>(n)];
  }
};

// The successful demonstrations among episodes: all, or as many as have kMostRows rows, more than an
// hour of them. Of more than that those stay whose hashes are smallest, drawn at random and yet
// the same in whatever order they come, so that 10,000 episodes take no more memory than 150.
struct DemonstrationSet {
  static constexpr Eigen::Index kMostRows = 400'000;
  static constexpr std::size_t kMostDocuments = 1000;

  std::vector<Demonstration> demonstrations;
  std::size_t unsuccessful = 0;     // left out
  std::size_t beyond = 0;           // successful and left out, as there were rows enough
  std::vector<std::string> scenes;  // names, sorted; more than one where they differ
  // Of the scenes that differ, with the parts as drawn, in JSON; the first kMostDocuments.
  std::vector<std::string> documents;
  std::vector<Json> undrawn_documents;  // of all of them, with the parts as they come
  double speed_scale = 0;  // of the hand: the scene's speed limit, scaled up, largest [m/s]
  std::optional<Scaling> scaling{};  // of all; empty where there is no episode
  double speed_limit = 0,
         force_limit = 0;                // of the scenes at the tip: largest, smallest [m/s], [N]
  std::vector<std::string> operators{};  // of all episodes, the unsuccessful ones too
  std::vector<EpisodeCopy> copies{};     // files that were left out as such, of no account above

  // Throws BadInput where the episode was recorded with another scaling than those before.
  void add(const EpisodeRows& episode, const std::string& file, const std::string& hash);
  Eigen::Index rows() const noexcept;
};

// From the row layout of one episode. Throws FileTrouble where its phases are damaged.
Demonstration demonstration(const EpisodeRows& episode, const Scene& scene,
                            const std::string& file);

// All episodes of a folder, copies of others left out. Throws FileTrouble, and BadInput if they were recorded with different
// scalings. `progress` is called with the number of episodes read, and of all; what it throws ends
// the loading.
DemonstrationSet load_demonstrations(
    const std::string& folder, const std::function<void(std::size_t, std::size_t)>& progress = {});
// The same of episode files.
DemonstrationSet load_demonstrations(
    const std::vector<std::string>& files,
    const std::function<void(std::size_t, std::size_t)>& progress = {});

// Throws BadInput if there are fewer successful demonstrations than a fit needs, three.
void refuse_too_few(const DemonstrationSet& set);

// For the file of what was learned from `training` of a set, and tested with `held_out`; each
// sorted by file. `seed`: of the split and the fit.
TrainedOn trained_on(const DemonstrationSet& set, const std::vector<const Demonstration*>& training,
                     const std::vector<const Demonstration*>& held_out, std::uint64_t seed);

}  // namespace ferrule
