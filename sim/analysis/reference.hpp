// What a plan measures models against: the full one along its probes.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "sim/analysis/plan.hpp"
#include "sim/analysis/probe.hpp"
#include "sim/analysis/sampled_run.hpp"
#include "sim/laws/particle.hpp"
#include "sim/scene/scene.hpp"

namespace ferrule {

inline constexpr double kFiner = 8;  // how much finer the steps are that a step is compared with
inline constexpr std::size_t kResampled = 2;       // probes that are sampled twice as finely
inline constexpr std::size_t kProbesForSteps = 4;  // along which steps are compared: one of a kind

// The runs of a plan, which may be stopped.
struct Runs {
  const PlanProgress& go_on;
  std::size_t most, done = 0;
  bool stopped = false;

  // Before each; false: no more.
  bool next() {
    stopped = stopped || (go_on && !go_on(done++, most));
    return !stopped;
  }
};

// The full model along its probes: what every reduced one is measured against.
struct Reference {
  Scene scene;
  Runs& watch;
  std::vector<Probe> probes;
  std::vector<SampledRun> runs;  // of each probe
  struct Extreme {
    double force = 0;  // the largest [N]
    State where;
  };
  std::array<Extreme, kTerms> extremes;
  void find_extremes(const StepResult& now);
  double compliance;                          // of the holder [m/N]
  double clearance;                           // [m]
  double force_scale = INFINITY;              // what force errors are relative to [N]
  bool sticks = false;                        // or snaps
  std::vector<std::vector<State>> intervals;  // of each probe, where they begin

  Reference(Scene full, Runs& watched);
  const Extreme& extreme(Term term) const { return extremes[static_cast<std::size_t>(term)]; }
  // What a missing force [N] can change: the felt force, and where the end is [-].
  double changes(double force) const {
    return force * std::max(1 / force_scale, compliance / clearance);
  }
  // What leaving a term out changes at most. A particle is not where the probes are: it lifts the
  // end by its height.
  double changes_without(Term term) const {
    const std::optional<Particle>& particle = scene.parameters.laws.particle;
    return changes(term == Term::particle && particle ? unusual_height(*particle) / compliance
                                                      : extreme(term).force);
  }
  // The largest error of a reduced model in any probe; infinite where not all were run.
  double error(const World& reduced) const;
  // What all but a few of the steps of a reduced model miss those by that `full` makes from the
  // same states.
  double error_of_steps(const World& reduced, const World& full) const;
  // What all but a few short intervals miss those by that begin in the same states and are taken
  // in kFiner times finer steps.
  double error_of_intervals() const;
  // By how much the full model ends elsewhere where the hand is sampled twice as finely.
  double sampled_twice() const;
};

}  // namespace ferrule
