// Episodes made by a known law at forces that are drawn, for tests.
#pragma once

#include "learn/solve_law.hpp"
#include "sim/base/random.hpp"

namespace ferrule::testing {

inline constexpr LawScales kScales{6e-3, 0.02};

// One set of gains for each law, of a hand's usual size.
inline Law usual_law(LawKind kind) {
  const std::vector<double> saturated = {-3e-3, 1e-4,  -5e-5, 2e-4,   0.9e-3, 0.8e-3, 5e-3, -1.8e-3,
                                         2e-4,  -1e-4, 4e-4,  1.6e-3, 1.4e-3, 0.3,    0.5};
  const std::vector<double> guarded = {4.2e-3, 0.9,    0.017, 0.006, 0.12, 2e-4,   0.85e-3,
                                       0.7e-3, 1.5e-5, -2e-5, -3e-3, 2e-3, 0.3e-3, 1.1e-3};
  const bool inserts = is_insertion_law(kind);
  const auto first = (inserts ? guarded : saturated).begin();
  return {kind, {first, first + static_cast<long>(gain_table(kind).size())}};
}

// `rows` rows every 10 ms with forces of up to 1.5 N that swing, and a hand that goes as the law
// says from 2 mm outside; the velocities carry noise of standard deviation `noise` [m/s] that lasts
// 0.3 s, as a hand's does.
inline std::vector<Samples> law_episodes(const Law& law, std::size_t episodes, int rows,
                                         double noise, std::uint64_t seed) {
  std::vector<Samples> all(episodes);
  for (std::size_t e = 0; e < episodes; ++e) {
    RandomStream random(seed, e, Draw::operator_hand);
    Eigen::Vector3d phase, frequency, wander = Eigen::Vector3d::Zero();
    for (int i = 0; i < 3; ++i) {
      phase[i] = 6.28 * random.uniform();
      frequency[i] = 0.5 + 2 * random.uniform();
    }
    double x = 2e-3;
    for (int n = 0; n < rows; ++n) {
      Sample s{};
      s.time = 0.01 * n;
      s.depth = std::max(0.0, -x);
      for (int i = 0; i < 3; ++i) {
        s.wrench[i] = 1.5 * std::sin(frequency[i] * s.time + phase[i]);
        wander[i] += -wander[i] * 0.01 / 0.3 + noise * std::sqrt(0.02 / 0.3) * random.normal();
      }
      const Eigen::Vector3d v = law_velocity(law.kind(), law.gains().data(), s);
      s.velocity = v + wander;
      x += 0.01 * v.x();
      all[e].push_back(s);
    }
  }
  return all;
}

}  // namespace ferrule::testing
