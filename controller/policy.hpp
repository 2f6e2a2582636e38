// A learned policy: small multilayer perceptrons from an observation to a Gaussian over the hand's
// velocity, in the hand's world. It runs without the library that trained it.
//
//   input    x = (w(t), w(t - s), ..., w(t - (H - 1) s), d(t)),
//            w the observed channels whose past is taken in too: the wrench [N, N m]; d the others:
//            the depth of the hand past the entrance [m] (controller/observation.hpp); not its own
//            velocity: it answers what it feels, not what it did
//   scaled   z = (x - mean) / scale, channel by channel
//   member   h_0 = z, h_i = tanh(W_i h_i-1 + b_i), (m, l) = W_n h_n-1 + b_n
//   velocity v = v_mean + v_scale m [m/s], standard deviation v_scale exp(l), l within
//            [kLowestLogSd, kHighestLogSd]
//
// The command is the mean over the members of an ensemble, cut to the policy's speed limit; the
// rates of tilt are 0. How much the members differ tells how far the state is from what they were
// trained on (Lakshminarayanan et al. 2017).
#pragma once

#include <array>
#include <vector>

#include "controller/controller.hpp"

namespace ferrule {

struct AnswerChannel {
  const char* name;
  const char* unit;
};
inline constexpr int kVelocity = 3;  // channels of the answer
inline constexpr std::array<AnswerChannel, kVelocity> kPolicyAnswer = {
    {{"velocity_x", "m/s"}, {"velocity_y", "m/s"}, {"velocity_z", "m/s"}}};
inline constexpr double kLowestLogSd = -4, kHighestLogSd = 2;

struct Layer {
  Eigen::MatrixXf weight;  // (outputs, inputs)
  Eigen::VectorXf bias;    // (outputs)
};
using Network = std::vector<Layer>;  // at least one hidden layer; the last one is linear

struct Policy {
  double period = 1e-3;    // between commands [s], > 0
  int samples = 1;         // H, >= 1
  int spacing = 1;         // s in periods, >= 1
  double speed_limit = 0;  // of the command, in the hand's world [m/s], > 0
  std::array<double, kPolicyChannels> mean{}, scale{};       // of kPolicyInputs; scale > 0
  Eigen::Vector3d velocity_mean = Eigen::Vector3d::Zero();   // [m/s]
  Eigen::Vector3d velocity_scale = Eigen::Vector3d::Zero();  // [m/s], >= 0
  std::vector<Network> members;                              // at least one, all of one shape

  int inputs() const noexcept { return kPastChannels * samples + kPresentChannels; }
  // Which of kPolicyInputs input i is.
  std::size_t channel(int i) const noexcept {
    const int present = i - kPastChannels * samples;
    return static_cast<std::size_t>(present < 0 ? i % kPastChannels : kPastChannels + present);
  }
};

// What a policy says of one state, without the speed limit [m/s].
struct PolicyAnswer {
  Eigen::Vector3d velocity;      // mean over the members
  Eigen::Vector3d deviation;     // standard deviation the members predict, root mean square
  Eigen::Vector3d disagreement;  // standard deviation among the members; 0 with one
};

class PolicyController : public Controller {
 public:
  explicit PolicyController(const Policy& policy);

  // To be called once per policy.period. Does not allocate.
  HandTwist command(const Observation& observation) noexcept override;

  // Of the last command.
  PolicyAnswer answer() const noexcept;
  double disagreement() const noexcept override { return answer().disagreement.norm(); }

 private:
  using Output = Eigen::Matrix<float, 2 * kVelocity, 1>;

  Policy policy_;
  Eigen::Matrix<float, kPastChannels, Eigen::Dynamic> past_;  // ring of scaled values
  Eigen::Index now_ = 0;                                      // its newest column
  Eigen::VectorXf input_;
  std::vector<Eigen::VectorXf> hidden_;  // one per layer
  std::vector<Output> outputs_;          // of the members
};

}  // namespace ferrule
