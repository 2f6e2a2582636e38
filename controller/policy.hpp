// A learned policy: small networks from an observation to a Gaussian over the hand's velocity, in
// the hand's world. It runs without the library that trained it. A multilayer perceptron sees the
// last moments only:
//
//   input    x = (w(t), w(t - s), ..., w(t - (H - 1) s), d(t)),
//            w the observed channels whose past is taken in too: the wrench [N, N m]; d the others:
//            the depth of the hand past the entrance [m] (controller/observation.hpp); not its own
//            velocity: it answers what it feels, not what it did
//   scaled   z = (x - mean) / scale, channel by channel
//   member   h_0 = z, h_i = tanh(W_i h_i-1 + b_i), (m, l) = W_n h_n-1 + b_n
//   velocity v = v_mean + v_scale m [m/s, rad/s], standard deviation v_scale exp(l), l within
//            [kLowestLogSd, kHighestLogSd]
//
// One with a memory knows what it did and felt since the start, and where: every s periods it takes
// in the wrench, its displacement and its height (kMemoryInputs), H = 1, and answers; in between it
// goes on. Its h_0 is the state of a gated recurrent unit (controller/gru.hpp), 0 at the start.
//
// The command is the mean over the members of an ensemble, its translation cut to the policy's
// speed limit. A policy whose demonstrators never tilted does not answer rates of tilt: they are 0.
// How much the members differ tells how far the state is from what they were trained on
// (Lakshminarayanan et al. 2017).
#pragma once

#include <array>
#include <span>
#include <vector>

#include "controller/controller.hpp"
#include "controller/gru.hpp"
#include "sim/base/control_period.hpp"

namespace ferrule {

struct AnswerChannel {
  const char* name;
  const char* unit;
};
inline constexpr int kVelocity = 3;  // channels of the answer of who does not tilt
inline constexpr int kTwist = HandTwist::RowsAtCompileTime;  // of who does
inline constexpr std::array<AnswerChannel, kTwist> kPolicyAnswer = {{{"velocity_x", "m/s"},
                                                                     {"velocity_y", "m/s"},
                                                                     {"velocity_z", "m/s"},
                                                                     {"tilt_rate_y", "rad/s"},
                                                                     {"tilt_rate_z", "rad/s"}}};
using PolicyTwist = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kTwist, 1>;  // 3 or 5
inline constexpr double kLowestLogSd = -4, kHighestLogSd = 2;

struct Layer {
  Eigen::MatrixXf weight;  // (outputs, inputs)
  Eigen::VectorXf bias;    // (outputs)
};
using Network = std::vector<Layer>;  // at least one hidden layer; the last one is linear

struct Policy {
  double period = kControlPeriod;  // between commands [s], > 0
  int samples = 1;                 // H, >= 1
  int spacing = 1;                 // s in periods, >= 1
  double speed_limit = 0;          // of the command, in the hand's world [m/s], > 0
  std::array<double, kMemoryChannels> mean{}, scale{};       // of channels(); scale > 0
  PolicyTwist velocity_mean = PolicyTwist::Zero(kVelocity);  // [m/s, rad/s]
  PolicyTwist velocity_scale = velocity_mean;                // [m/s, rad/s], >= 0
  std::vector<Network> members;                              // at least one, all of one shape
  std::vector<Gru> memories{};  // what each member remembers by; empty: it does not

  std::span<const ObservationChannel> channels() const noexcept {
    if (memories.empty()) return kPolicyInputs;
    return kMemoryInputs;
  }
  int inputs() const noexcept {
    return kPastChannels * (samples - 1) + static_cast<int>(channels().size());
  }
  int answers() const noexcept { return static_cast<int>(velocity_mean.size()); }
  // Which of channels() input i is.
  std::size_t channel(int i) const noexcept {
    const int present = i - kPastChannels * samples;
    return static_cast<std::size_t>(present < 0 ? i % kPastChannels : kPastChannels + present);
  }
};

// What a policy says of one state, without the speed limit [m/s, rad/s].
struct PolicyAnswer {
  HandTwist velocity = HandTwist::Zero();      // mean over the members
  HandTwist deviation = HandTwist::Zero();     // standard deviation they predict, root mean square
  HandTwist disagreement = HandTwist::Zero();  // standard deviation among them; 0 with one
};

class PolicyController : public Controller {
 public:
  explicit PolicyController(const Policy& policy);

  // To be called once per policy.period. Does not allocate.
  HandTwist command(const Observation& observation) noexcept override;

  // Of the last command.
  PolicyAnswer answer() const noexcept;
  double disagreement() const noexcept override {
    return answer().disagreement.head<kVelocity>().norm();
  }

 private:
  using Output = Eigen::Matrix<float, Eigen::Dynamic, 1, 0, 2 * kTwist, 1>;

  void take_in(const Observation& observation) noexcept;

  Policy policy_;
  Eigen::Matrix<float, kPastChannels, Eigen::Dynamic> past_;  // ring of scaled values
  Eigen::Index now_ = 0;                                      // its newest column
  Eigen::VectorXf input_;
  std::vector<Eigen::VectorXf> hidden_;  // one per layer
  std::vector<GruState> memory_;         // of the members
  int periods_ = 0;                      // since the last answer of one with a memory
  std::vector<Output> outputs_;          // of the members
  HandTwist command_ = HandTwist::Zero();
};

}  // namespace ferrule
