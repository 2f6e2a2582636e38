// Demonstrations made by a known law at forces that swing, for tests.
#pragma once

#include "learn/demonstrations.hpp"
#include "sim/base/random.hpp"

namespace ferrule::testing {

// An observation without moments.
inline Observation felt(const Eigen::Vector3d& force, double depth, double time) {
  Observation observation{HandWrench::Zero(), depth, time};
  observation.wrench.head<3>() = force;
  return observation;
}

// 15 s each, from 15 mm outside the bore, forces of up to 1.5 N. The hand goes as `law(force [N],
// depth [m], time [s])` says [m/s], of the force `delay` ms before; the velocities carry noise of
// standard deviation `noise` [m/s] that lasts 0.3 s, as a hand's does. `speed_scale` [m/s].
template <class LawOf>
DemonstrationSet demonstrations(const LawOf& law, double speed_scale, int episodes, int delay = 0,
                                double noise = 0, std::uint64_t seed = 1) {
  constexpr int kRows = 15000;
  DemonstrationSet set;
  set.scenes = {"synthetic"};
  set.speed_scale = speed_scale;
  for (int e = 0; e < episodes; ++e) {
    RandomStream random(seed, static_cast<std::uint64_t>(e), Draw::operator_hand);
    Demonstration d;
    d.file = "episode " + std::to_string(e);
    d.outcome = Outcome::inserted;
    d.period = 1e-3;
    d.speed_limit = speed_scale;
    d.velocity.resize(kRows, 3);
    d.tilt_rates.setZero(kRows, 2);
    Eigen::Vector3d phase, frequency;
    for (int i = 0; i < 3; ++i) {
      phase[i] = 6.28 * random.uniform();
      frequency[i] = 0.5 + 2 * random.uniform();
    }
    double depth = -0.015, wander = 0;
    for (int n = 0; n < kRows; ++n) {
      const double t = n * 1e-3;
      Eigen::Vector3d force;
      for (int i = 0; i < 3; ++i) force[i] = 1.5 * std::sin(frequency[i] * t + phase[i]);
      d.observations.push_back(felt(force, std::max(0.0, depth), t));
      const Eigen::Vector3d answered = d.observed(n - delay).wrench.head<3>();
      const Eigen::Vector3d v = law(answered, d.observed(n).depth, t);
      depth -= v.x() * 1e-3;
      wander += -wander * 1e-3 / 0.3 + noise * std::sqrt(2e-3 / 0.3) * random.normal();
      d.velocity.row(n) = (v + Eigen::Vector3d::Constant(wander)).transpose();
    }
    set.demonstrations.push_back(d);
  }
  return set;
}

}  // namespace ferrule::testing
