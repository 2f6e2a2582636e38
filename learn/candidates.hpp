// Ways to insert, on the same trials: what `ferrule compare` sets side by side.
#pragma once

#include <optional>

#include "controller/campaign.hpp"
#include "controller/law.hpp"
#include "insertion/operator_skill.hpp"
#include "learn/learner.hpp"

namespace ferrule {

struct Candidate {
  std::string name;
  MakeController make;         // for trials under the seed it was made for
  std::size_t parameters = 0;  // numbers that were fitted; 0 where nothing was
  double fit_seconds = 0;
  std::optional<double> held_out{};  // root mean square velocity error, hand's world [m/s]
  std::size_t rollouts = 0;   // labelled ones of its own, learned from beside the demonstrations
  std::uint64_t periods = 1;  // from one answer of its own to the next, which it holds in between
  std::optional<ControllerFile> file{};  // empty: it is not one of ours
};

// What an engineer sets without demonstrations: straight in at `speed` [m/s, hand's world], at half
// of it where 2 N are felt, and sideways as compliant as a hand, 1 mm/s per newton.
Law tuned_by_hand(double speed);

// Those that learn nothing: constant velocity, an admittance tuned by hand, the fastest
// demonstration played again, and the simulated operator of `skill`, each for trials of `scene`
// under `seed`.
std::vector<Candidate> baselines(const Scene& scene, const DemonstrationSet& set,
                                 const OperatorSkill& skill, std::uint64_t seed);

// All learners. Those that need libtorch throw BadInput where it is missing.
const std::vector<Learner>& learners();

// What one variant of a learner makes of demonstrations. `seed`: of the fit. Throws BadInput, and
// what `progress` throws.
ControllerFile learned(const Learner& learner, const Learner::Variant& variant,
                       const DemonstrationSet& set, std::uint64_t seed,
                       const LearnerProgress& progress = {});
// That as a candidate, of a fit that took `seconds`.
Candidate candidate(const std::string& name, const ControllerFile& learned, double seconds);

// The first `count` demonstrations of a set.
DemonstrationSet first_of(const DemonstrationSet& set, std::size_t count);

// Time of one answer [ns], on what was observed in a demonstration.
double ns_per_action(const Candidate& candidate, const Demonstration& demonstration);

}  // namespace ferrule
