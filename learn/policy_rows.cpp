#include "learn/policy_rows.hpp"

#include <cmath>

#include "learn/samples.hpp"

namespace ferrule {
namespace {

constexpr double kResting = 0.1;         // of the speed limit
constexpr double kLeastVelocity = 1e-9;  // least standard deviation of one that varies [m/s, rad/s]

PolicyRows rows_of(const Demonstration& d, double reaction, const Policy& policy) {
  const bool remembers = !policy.memories.empty();
  PolicyRows rows{Eigen::MatrixXd(policy.inputs(), d.rows()),
                  Eigen::MatrixXd(policy.answers(), d.rows()), Eigen::RowVectorXd(d.rows())};
  const auto delay = static_cast<Eigen::Index>(std::lround(reaction / d.period));
  const auto spacing =
      static_cast<Eigen::Index>(std::lround(policy.spacing * policy.period / d.period));
  const Eigen::Index stride = remembers ? spacing : rows_per_step(d.period);
  Eigen::Index count = 0;
  for (Eigen::Index n = 0; n < d.rows(); n += stride) {
    const bool rests = d.velocity.row(n).norm() < kResting * d.speed_limit;
    const bool cut = cut_to_limit(d, n);
    if (!remembers && (rests || cut)) continue;
    for (int i = 0; i < policy.inputs(); ++i) {
      const ObservationChannel& channel = policy.channels()[policy.channel(i)];
      const bool past = channel.policy == PolicyInput::past;
      rows.input(i, count) =
          channel.value(d.observed(past ? n - delay - i / kPastChannels * spacing : n));
    }
    rows.velocity.col(count).head<kVelocity>() = d.velocity.row(n);
    for (int i = kVelocity; i < policy.answers(); ++i)
      rows.velocity(i, count) = d.tilt_rates(n, i - kVelocity);
    rows.told[count++] = cut ? 0 : 1;
  }
  rows.input.conservativeResize(Eigen::NoChange, count);
  rows.velocity.conservativeResize(Eigen::NoChange, count);
  rows.told.conservativeResize(count);
  return rows;
}

// One after the other.
PolicyRows joined(const std::vector<PolicyRows>& all, const Policy& policy) {
  const Eigen::Index n = count(all);
  PolicyRows one{Eigen::MatrixXd(policy.inputs(), n), Eigen::MatrixXd(policy.answers(), n),
                 Eigen::RowVectorXd(n)};
  Eigen::Index first = 0;
  for (const PolicyRows& rows : all) {
    one.input.middleCols(first, rows.count()) = rows.input;
    one.velocity.middleCols(first, rows.count()) = rows.velocity;
    one.told.segment(first, rows.count()) = rows.told;
    first += rows.count();
  }
  return one;
}

struct MeanAndSd {
  double mean, sd;
};
MeanAndSd spread(const Eigen::RowVectorXd& values) {
  const double mean = values.mean();
  return {mean, std::sqrt((values.array() - mean).square().mean())};
}

Eigen::MatrixXf scaled_inputs(const Policy& policy, const Eigen::MatrixXd& inputs) {
  Eigen::MatrixXf z(inputs.rows(), inputs.cols());
  for (int i = 0; i < policy.inputs(); ++i) {
    const std::size_t channel = policy.channel(i);
    z.row(i) =
        ((inputs.row(i).array() - policy.mean[channel]) / policy.scale[channel]).cast<float>();
  }
  return z;
}

// What the memory holds at each column of `z`, (units, rows).
Eigen::MatrixXf remembered(const Gru& gru, const Eigen::MatrixXf& z) {
  GruState state(gru.units());
  Eigen::MatrixXf all(gru.units(), z.cols());
  for (Eigen::Index n = 0; n < z.cols(); ++n) {
    state.take_in(gru, z.col(n));
    all.col(n) = state.h();
  }
  return all;
}

// The mean answer to each column of `inputs`, one after the other, without the speed limit.
Eigen::MatrixXd mean_answers(const Policy& policy, const Eigen::MatrixXd& inputs) {
  const Eigen::MatrixXf z = scaled_inputs(policy, inputs);
  Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(policy.answers(), inputs.cols());
  for (std::size_t m = 0; m < policy.members.size(); ++m) {
    const Network& network = policy.members[m];
    Eigen::MatrixXf h = policy.memories.empty() ? z : remembered(policy.memories[m], z);
    for (std::size_t i = 0; i < network.size(); ++i) {
      h = (network[i].weight * h).colwise() + network[i].bias;
      if (i + 1 < network.size()) h = h.array().tanh();
    }
    mean += h.topRows(policy.answers()).cast<double>() / static_cast<double>(policy.members.size());
  }
  return (policy.velocity_scale.asDiagonal() * mean).colwise() +
         Eigen::VectorXd(policy.velocity_mean);
}

}  // namespace

std::vector<PolicyRows> policy_rows(const std::vector<const Demonstration*>& set, double reaction,
                                    const Policy& policy) {
  std::vector<PolicyRows> all;
  for (const Demonstration* d : set) all.push_back(rows_of(*d, reaction, policy));
  return all;
}

Eigen::Index count(const std::vector<PolicyRows>& all) noexcept {
  Eigen::Index sum = 0;
  for (const PolicyRows& rows : all) sum += rows.count();
  return sum;
}

void set_scales(Policy& policy, const std::vector<PolicyRows>& all) {
  const PolicyRows rows = joined(all, policy);
  // From the inputs of now: the first of the past, and those after it.
  for (int i = 0; i < policy.inputs(); ++i) {
    if (i >= kPastChannels && i < kPastChannels * policy.samples) continue;
    const std::size_t channel = policy.channel(i);
    const MeanAndSd s = spread(rows.input.row(i));
    policy.mean[channel] = s.mean;
    policy.scale[channel] = s.sd > policy.channels()[channel].negligible ? s.sd : 1;
  }
  for (int i = 0; i < policy.answers(); ++i) {
    const MeanAndSd s = spread(rows.velocity.row(i));
    policy.velocity_mean[i] = s.mean;
    policy.velocity_scale[i] = s.sd > kLeastVelocity ? s.sd : 0;
  }
}

std::vector<TrainingRows> scaled(const Policy& policy, const std::vector<PolicyRows>& all) {
  std::vector<TrainingRows> scaled;
  for (const PolicyRows& rows : all) {
    scaled.push_back({scaled_inputs(policy, rows.input),
                      Eigen::MatrixXf::Zero(policy.answers(), rows.count()),
                      rows.told.cast<float>()});
    for (int i = 0; i < policy.answers(); ++i)
      if (policy.velocity_scale[i] > 0)
        scaled.back().velocity.row(i) =
            ((rows.velocity.row(i).array() - policy.velocity_mean[i]) / policy.velocity_scale[i])
                .cast<float>();
  }
  return scaled;
}

double squared_error(const Policy& policy, const PolicyRows& rows) {
  return (mean_answers(policy, rows.input) - rows.velocity).topRows<kVelocity>().squaredNorm();
}

}  // namespace ferrule
