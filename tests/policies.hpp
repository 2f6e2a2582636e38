// Policies with weights that are drawn, for tests.
#pragma once

#include "controller/policy_file.hpp"
#include "sim/base/random.hpp"

namespace ferrule::testing {

inline Eigen::MatrixXf random_matrix(Eigen::Index rows, Eigen::Index columns, double scale,
                                     RandomStream& random) {
  Eigen::MatrixXf m(rows, columns);
  for (Eigen::Index r = 0; r < rows; ++r)
    for (Eigen::Index c = 0; c < columns; ++c)
      m(r, c) = static_cast<float>(scale * random.normal());
  return m;
}

// With `units` of memory, and answers of rates of tilt where it `tilts`.
inline Policy random_policy(std::size_t members, std::vector<int> hidden, int samples, int spacing,
                            std::uint64_t seed = 1, Eigen::Index units = 0, bool tilts = false) {
  RandomStream random(seed, 0, Draw::plan);
  Policy p;
  if (units > 0) p.memories.resize(members);
  if (tilts) p.velocity_mean = p.velocity_scale = PolicyTwist::Zero(kTwist);
  p.samples = samples;
  p.spacing = spacing;
  p.speed_limit = 0.01;
  for (std::size_t i = 0; i < p.channels().size(); ++i) {
    p.mean[i] = random.normal();
    p.scale[i] = 0.2 + random.uniform();
  }
  for (int i = 0; i < p.answers(); ++i) {
    p.velocity_mean[i] = 1e-3 * random.normal();
    p.velocity_scale[i] = 1e-3 * (1 + random.uniform());
  }
  for (Gru& gru : p.memories)
    gru = {random_matrix(3 * units, p.inputs(), 1 / std::sqrt(p.inputs()), random),
           random_matrix(3 * units, units, 1 / std::sqrt(units), random),
           random_matrix(3 * units, 1, 0.3, random), random_matrix(3 * units, 1, 0.3, random)};
  hidden.push_back(2 * p.answers());
  for (std::size_t m = 0; m < members; ++m) {
    Network network;
    int inputs = units > 0 ? static_cast<int>(units) : p.inputs();
    for (const int units : hidden) {
      Layer layer{Eigen::MatrixXf(units, inputs), Eigen::VectorXf(units)};
      for (int r = 0; r < units; ++r) {
        layer.bias[r] = static_cast<float>(0.3 * random.normal());
        for (int c = 0; c < inputs; ++c)
          layer.weight(r, c) = static_cast<float>(random.normal() / std::sqrt(inputs));
      }
      network.push_back(layer);
      inputs = units;
    }
    p.members.push_back(network);
  }
  return p;
}

inline PolicyFile random_policy_file() {
  PolicyFile f;
  f.policy = random_policy(2, {7, 5}, 3, 4);
  f.trained_on.scenes = {"demo"};
  f.trained_on.episodes = {{"a.h5", "da39a3ee5e6b4b0d3255bfef95601890afd80709"}};
  f.trained_on.held_out = {{"b.h5", "a9993e364706816aba3e25717850c26c9cd0d89d"}};
  f.trained_on.rows = 1234;
  f.reaction_time = 0.17;
  f.members = {{30, 20, -1.5, -1.25}, {31, 25, -1.5, -1.0, 200, 199}};
  f.dagger = {{10, 9, 500, -1.125}};
  return f;
}

// A wrench, a depth and a motion that are drawn.
inline Observation random_observation(RandomStream& random) {
  Observation observation{HandWrench::Zero(), 2 * random.uniform(), 0};
  for (int i = 0; i < kWrenchChannels; ++i) observation.wrench[i] = 2 * random.normal();
  for (int i = 0; i < kTwist; ++i) observation.displacement[i] = 2 * random.normal();
  observation.height = 2 * random.normal();
  return observation;
}

// The inputs of a policy, not scaled, after all that was seen so far.
inline Eigen::VectorXd policy_inputs(const Policy& p, const std::vector<Observation>& seen) {
  Eigen::VectorXd inputs(p.inputs());
  const auto now = static_cast<std::ptrdiff_t>(seen.size()) - 1;
  for (int i = 0; i < p.inputs(); ++i) {
    const bool past = i < kPastChannels * p.samples;
    const std::ptrdiff_t at = past ? now - i / kPastChannels * p.spacing : now;
    inputs[i] = at < 0 ? 0.0 : p.channels()[p.channel(i)].value(seen[static_cast<std::size_t>(at)]);
  }
  return inputs;
}

}  // namespace ferrule::testing
