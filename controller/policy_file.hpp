// controller.json of method "torch": a learned policy (controller/policy.hpp) with all that is
// needed to run it and to know where it came from. Its weights are in a safetensors file beside it.
// controller/README.md describes the keys, data/controller.schema.json states them.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "controller/policy.hpp"
#include "controller/trained_on.hpp"

namespace ferrule {

// How one member's training went.
struct MemberTraining {
  int epochs = 0;            // until it stopped
  int best_epoch = 0;        // whose weights were kept
  double training_loss = 0;  // negative log likelihood per row at the best epoch, scaled velocities
  double held_out_loss = 0;
  std::size_t rollouts = 0, inserted = 0;  // that chose the epoch: of each epoch tried, of the best
};

// One round of running the policy, asking the simulated operator and training again.
struct DaggerRound {
  std::size_t trials = 0, inserted = 0;
  std::size_t rows = 0;      // added to the training rows
  double held_out_loss = 0;  // after training again, mean over the members
};

struct PolicyFile {
  Policy policy;
  double reaction_time = 0;  // delay of the demonstrator, undone in training [s]
  // How it was trained.
  double input_noise = 0;   // standard deviation added to scaled inputs
  double weight_decay = 0;  // of AdamW
  // Provenance.
  TrainedOn trained_on;
  std::vector<MemberTraining> members;
  // Root mean square of the velocity error [m/s]. Held out: of each demonstration by the weights
  // that rollouts chose, or the others held out; NaN where only one was, and there were no rollouts.
  double residual = 0, held_out_residual = 0;
  std::vector<DaggerRound> dagger;

  MakeController maker() const { return controller_maker(PolicyController(policy)); }
  std::size_t parameters() const;  // weights and biases, of all members
};

// Where weights of that SHA-1 are written for a controller `file`: beside it, STEM.HASH.safetensors
// with 12 digits of it. Throws BadInput where `file` itself ends so.
std::string weights_file(const std::string& file, const std::string& hash);
// Writes the weights, then `file`, which names them and their hash, and removes the weights of the
// controller that it replaces; killed at any point, one of the two controllers is there and whole.
// Throws BadInput, FileTrouble.
void write_controller(const std::string& file, const PolicyFile& policy);
// Throws FileTrouble, BadInput.
PolicyFile read_policy(const std::string& file);
// From the text of `file`, with the weights beside it. Throws FileTrouble, BadInput.
PolicyFile parse_policy(const Json& json, const std::string& file);

}  // namespace ferrule
