// What libtorch is used for: training a network, and writing a policy as TorchScript. Only
// torch_policy.cpp knows libtorch; it is a library of its own, loaded when first needed, so that
// nothing else waits for libtorch to start.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "controller/policy.hpp"
#include "controller/program_policy.hpp"

namespace ferrule {

// Scaled rows of one demonstration: what was observed, and the velocity that answers it.
struct TrainingRows {
  Eigen::MatrixXf input;     // (inputs, rows)
  Eigen::MatrixXf velocity;  // (answers, rows)
  Eigen::RowVectorXf told;   // (rows): 1 where the velocity counts, 0 where it says nothing
};

struct TrainingSettings {
  std::vector<int> hidden = {64, 64};  // units of each hidden layer
  int epochs = 60;                     // at most
  int patience = 12;                   // epochs without a better held-out loss, then it stops
  int batch = 256;                     // rows of a step
  double learning_rate = 1e-3;         // falls to 0 along half a cosine
  double weight_decay = 1e-4;          // decoupled, of AdamW (Loshchilov and Hutter 2019)
  double input_noise = 0.05;           // standard deviation added to scaled inputs, each batch anew
  // Of networks with a memory; the others have none.
  int memory = 0;             // units
  double motion_noise = 0.2;  // as input_noise, of what tells where the hand is
  int window = 500;           // rows that an error is traced back through
  int together = 8;           // episodes of a step
};

// Losses are negative log likelihoods per row, without the constant:
//   sum over the channels of (v - m)^2 / (2 exp(2 l)) + l
struct Epoch {
  double training_loss, held_out_loss;
};

struct Weights {
  Network network;
  Gru memory{};  // what it remembers by; empty: it does not
};

// What a training had come to.
struct Snapshot {
  std::size_t epochs;  // by then
  Weights weights;
};

struct TrainedNetwork {
  Weights weights;           // of the best epoch by held-out loss
  std::vector<Epoch> curve;  // one per epoch
  std::size_t best = 0;      // index into it
  // For each demonstration that was held out, those of the best epoch by the loss of the others:
  // weights that it can grade, as it did not choose them. None where only one was held out.
  std::vector<Weights> chosen_without{};
  std::vector<Snapshot> snapshots{};  // after each tenth of the epochs
};

// `progress` is called after each step and each epoch with how many epochs are whole, and the losses
// of the last of them (NaN before the first). False ends the training there: the epoch counts as far
// as it went.
using TrainingProgress = std::function<bool(std::size_t epoch, const Epoch&)>;

// Trains one network: Gaussian likelihood, AdamW, early stopping. One thread; the same arguments
// give the same bits on one machine. Throws BadInput if the program was built without libtorch,
// FileTrouble if libtorch cannot be loaded.
//
// One with a memory learns from demonstrations as they went: each step goes through a window of some
// of them, and what they left in the memory goes on into the next window. The norm of a step's
// gradient is cut to 1. A network that sees where the hand was sees how fast it went, and the easiest
// answer is to go on as before: one that slows then stops (Wen et al. 2020, "Fighting copycat agents"). The
// noise of the motion hides the last steps, and leaves where the hand is.
TrainedNetwork train_network(const std::vector<TrainingRows>& training,
                             const std::vector<TrainingRows>& held_out,
                             const TrainingSettings& settings, std::uint64_t seed,
                             const TrainingProgress& progress);

// A TorchScript module whose forward takes unscaled inputs (rows, inputs), float64, and returns
// (velocity, deviation, disagreement), each (rows, answers) float64: the velocity as the controller
// commands it, the others as in PolicyAnswer. One with a memory also takes what it remembers,
// (members, rows, units) float32, 0 at the start, and returns what it remembers then. Throws as
// train_network.
std::string torchscript_bytes(const Policy& policy);

// What libtorch answers when it runs these bytes, (3 answers, rows); of one with a memory, `memory`
// numbers in all, row after row. For tests. Throws as train_network.
Eigen::MatrixXd run_torchscript(const std::string& bytes, const Eigen::MatrixXd& inputs,
                                std::array<int, 2> memory = {});

// A controller for TorchScript of anybody's: forward takes an observation, float32 (1, 7), in the
// order of kObservation and kMotion: Fx Fy Fz [N], My Mz [N m], depth [m], time [s], and where it
// refuses (1, 7) also displacement x y z [m], tilt_y tilt_z [rad], height [m], and where it refuses
// (1, 13) also the force at the holder that ends the trial [N], all in the hand's world; and
// returns a velocity, (1, 5) or (5): x y z [m/s], tilt_y tilt_z [rad/s], or the first three; or a
// tuple of that and a bool: the insertion is over, as far as it is concerned. Every trial has a
// module of its own, so that it may remember; where it has a method `reset`, that is called first.
// Throws FileTrouble where these bytes are none, and as train_network.
std::unique_ptr<Controller> torchscript_controller(const std::string& bytes);
// What makes it for each trial, of a file of a stranger: in processes of their own
// (controller/program_policy.hpp), for such a module may crash, hang or take all memory. At most
// 512 MB, and each process 1 GB more than four times the file. Throws as torchscript_controller.
MakeController load_torchscript(const std::string& file, const ProgramSettings& settings);

// The same functions in the library of their own.
struct TorchFunctions {
  decltype(&train_network) train;
  decltype(&torchscript_bytes) script;
  decltype(&run_torchscript) run;
  decltype(&torchscript_controller) controller;
};

}  // namespace ferrule
