// Behaviour cloning: trains a policy (controller/policy.hpp) on demonstrations with libtorch.
//
// A perceptron learns from rows every 10 ms (learn/policy_rows.hpp), with the wrench at H samples of
// the past; one with a memory from each demonstration as it went, every 20 ms. The reaction time of
// the demonstrators is identified as in fit_law, and undone. Inputs and velocities are scaled by
// their mean and standard deviation over the training rows; a velocity that does not vary is
// answered exactly. About a fifth of the demonstrations is held out, whole, and decides which
// epoch's weights are kept. The held-out error is another thing: each of them is predicted by the
// weights of the epoch that the others of them would have chosen, which knew nothing of it.
// Of one with a memory rollouts decide (learn/choose_weights.hpp): how well it predicts says little
// of how often it inserts, as what it does now decides what it remembers next.
//
// DAgger (Ross et al. 2011), for simulated operators: each round lets the policy insert in new
// starts, asks the simulated operator what it would have done in every state met
// (learn/relabel.hpp) and trains again on all of it.
#pragma once

#include "learn/learner.hpp"

namespace ferrule {

struct PolicySettings {
  TrainingSettings training;
  std::size_t members = 1;  // of the ensemble, each from its own start
  int samples = 3;          // of the past
  double spacing = 0.04;    // between them [s]; of one with a memory between its answers
  std::size_t dagger_rounds = 0;
  std::size_t rollouts = 0;  // of each of the weights among which they choose; 0: they do not
  std::uint64_t seed = 1;    // of the split, of the members and of the trials of DAgger
  std::optional<std::uint64_t> network_seed{};  // of the members, apart from the others
};

// Of networks with a memory.
PolicySettings memory_settings();

struct PolicyFit {
  PolicyFile file;
  std::vector<std::vector<Epoch>> curves;  // of the members, in the last round
};

// `progress` gets the epochs done, of (dagger_rounds + 1) members epochs at most, and the last
// one's losses (NaN before the first), after each step of a training and each rollout. False ends it
// with what there is: the rounds that are whole, or of the first the members that are whole, or of
// the first member the best epoch so far.
using PolicyProgress = std::function<bool(std::size_t done, const Epoch&)>;

// Throws BadInput where the demonstrations are too few (fewer than 3 successful ones, or fewer than
// 300 rows in 10 ms steps) and as train_network.
PolicyFit fit_policy(const DemonstrationSet& set, const PolicySettings& settings,
                     const PolicyProgress& progress);

// fit_policy in the table of learners.
Learner policy_learner();

}  // namespace ferrule
