#include "controller/policy.hpp"

#include <algorithm>

#include "sim/base/elementary.hpp"

namespace ferrule {

PolicyController::PolicyController(const Policy& policy)
    : policy_(policy),
      past_(kPastChannels, (policy.samples - 1) * policy.spacing + 1),
      input_(policy.inputs()),
      outputs_(policy.members.size(), Output::Zero(Eigen::Index{2} * policy.answers())) {
  // Before the start the hand was at rest: it felt nothing.
  for (int i = 0; i < kPastChannels; ++i) {
    const auto c = static_cast<std::size_t>(i);
    past_.row(i).setConstant(static_cast<float>(-policy.mean[c] / policy.scale[c]));
  }
  const Network& network = policy_.members.front();
  for (std::size_t i = 0; i + 1 < network.size(); ++i)
    hidden_.emplace_back(Eigen::VectorXf::Zero(network[i].bias.size()));
  for (const Gru& gru : policy_.memories) memory_.emplace_back(gru.units());
}

void PolicyController::take_in(const Observation& observation) noexcept {
  const auto scaled = [&](std::size_t channel) {
    const double x = policy_.channels()[channel].value(observation);
    return static_cast<float>((x - policy_.mean[channel]) / policy_.scale[channel]);
  };
  now_ = now_ + 1 < past_.cols() ? now_ + 1 : 0;
  for (int i = 0; i < kPastChannels; ++i) past_(i, now_) = scaled(static_cast<std::size_t>(i));
  for (Eigen::Index k = 0; k < policy_.samples; ++k) {
    const Eigen::Index column = now_ - k * policy_.spacing;
    input_.segment<kPastChannels>(k * kPastChannels) =
        past_.col(column >= 0 ? column : column + past_.cols());
  }
  for (int i = kPastChannels * policy_.samples; i < policy_.inputs(); ++i)
    input_[i] = scaled(policy_.channel(i));
}

HandTwist PolicyController::command(const Observation& observation) noexcept {
  if (!memory_.empty()) {
    const bool go_on = periods_ > 0;
    periods_ = (periods_ + 1) % policy_.spacing;
    if (go_on) return command_;
  }
  take_in(observation);
  const int n = policy_.answers();
  PolicyTwist sum = PolicyTwist::Zero(n);
  for (std::size_t m = 0; m < policy_.members.size(); ++m) {
    const Network& network = policy_.members[m];
    const Eigen::VectorXf* below = &input_;
    if (!memory_.empty()) {
      memory_[m].take_in(policy_.memories[m], input_);
      below = &memory_[m].h();
    }
    for (std::size_t i = 0; i < hidden_.size(); ++i) {
      hidden_[i] = network[i].bias;
      hidden_[i].noalias() += network[i].weight * *below;
      hidden_[i] = hidden_[i].array().tanh();
      below = &hidden_[i];
    }
    outputs_[m] = network.back().bias;
    outputs_[m].noalias() += network.back().weight * *below;
    sum += outputs_[m].head(n).cast<double>();
  }
  HandTwist velocity = HandTwist::Zero();
  velocity.head(n) = policy_.velocity_mean + policy_.velocity_scale.cwiseProduct(
                                                 sum / static_cast<double>(outputs_.size()));
  command_ = limit_speed(velocity, policy_.speed_limit);
  return command_;
}

PolicyAnswer PolicyController::answer() const noexcept {
  using Array = Eigen::Array<double, Eigen::Dynamic, 1, 0, kTwist, 1>;
  const double n = static_cast<double>(outputs_.size());
  const int answers = policy_.answers();
  Array mean = Array::Zero(answers), variance = mean, among = mean;
  for (const Output& output : outputs_) {
    mean += output.head(answers).cast<double>().array() / n;
    const Array log_sd = output.tail(answers).cast<double>().array();
    variance += (2 * log_sd.max(kLowestLogSd).min(kHighestLogSd)).unaryExpr([](double x) {
      return elementary::exp(x);
    }) / n;
  }
  for (const Output& output : outputs_)
    among += (output.head(answers).cast<double>().array() - mean).square() / n;
  const Array scale = policy_.velocity_scale.array();
  PolicyAnswer answer;
  answer.velocity.head(answers) = policy_.velocity_mean + (scale * mean).matrix();
  answer.deviation.head(answers) = scale * variance.sqrt();
  answer.disagreement.head(answers) = scale * among.sqrt();
  return answer;
}

}  // namespace ferrule
