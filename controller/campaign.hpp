// A campaign: many trials of one kind of controller in one scene, on all cores, with the same
// result for any number of threads.
#pragma once

#include <functional>
#include <vector>

#include "controller/enough.hpp"
#include "controller/graded_joint.hpp"
#include "controller/mated_pairs.hpp"
#include "controller/quantiles.hpp"
#include "controller/statistics.hpp"
#include "controller/trial.hpp"
#include "controller/trial_store.hpp"
#include "controller/worst_tenth.hpp"

namespace ferrule {

// Says of the results of a campaign, shown one at a time in the order of the trials, after which
// one it is long enough (controller/enough.hpp).
using IsEnough = std::function<bool(const TrialResult&)>;

// Results in the order of the trials. `threads` 0: all cores. `progress` is called with the number
// of trials done, from any thread. Once `stop` says so, from any thread, all trials end: the
// results are those of the first trials up to one that was not done, fewer than `trials`. The trial
// after which it is `enough` is the last. `kept`: where other processes have their part in the
// trials and this one goes on with what it has (controller/trial_store.hpp); a shard returns none,
// unless what comes next depends on them. A trial whose policy the system ended is run again.
// Throws what `make` and `kept` throw, and BadInput where that does not help.
std::vector<TrialResult> run_campaign(const Scene& scene, const MakeController& make,
                                      std::uint64_t seed, std::size_t trials, int threads,
                                      const std::function<void(std::size_t)>& progress,
                                      const std::function<bool()>& stop = {},
                                      const IsEnough& enough = {}, TrialStore* kept = nullptr);

// Several at once, each with the same trials, so that those of all fill the cores.
struct Campaign {
  const Scene* scene;
  MakeController make;
  IsEnough enough{};
  // Gets all results, one at a time in the order of the trials.
  std::function<void(const TrialResult&)> each{};
  std::size_t keep = SIZE_MAX;  // of the results that are returned: the first so many
  std::string redrawn{};        // as of trial_setup
};
// The results of each, as of run_campaign.
std::vector<std::vector<TrialResult>> run_campaigns(
    const std::vector<Campaign>& campaigns, std::uint64_t seed, std::size_t trials, int threads,
    const std::function<void(std::size_t)>& progress, const std::function<bool()>& stop = {},
    TrialStore* kept = nullptr);

struct Spread {
  double median, p95;  // NaN where there is nothing to take them of
};

// What supervisors did in a campaign.
struct InterventionSummary {
  struct Kind {
    std::size_t count, trials;  // how often; in how many trials
  };
  std::array<Kind, kInterventions> kinds;           // by Intervention
  std::size_t trials;                               // with any
  std::array<std::size_t, kInterventions> gave_up;  // trials, by why
};

// Connectors that were inserted so, mated at random, and what they lose at all wavelengths.
struct Mated {
  MatedPairs untuned, tuned;
  std::vector<MatedPairs> untuned_at, tuned_at;  // each wavelength of the joint
  GradedJoint joint;
};

struct CampaignSummary {
  std::size_t trials, feasible, successes;
  double success_rate;                               // of the feasible trials; NaN without any
  Interval wilson;                                   // 95 %
  std::array<std::size_t, kOutcomes> outcomes;       // by Outcome
  Spread time;                                       // of the insertions that succeeded [s]
  Spread peak_force;                                 // of all feasible trials [N]
  Spread loss_dB;                                    // of the insertions that succeeded
  std::optional<InterventionSummary> interventions;  // where there was a supervisor
  std::int64_t steps, unfinished;                    // of all trials, as in InsertionSummary
  std::optional<Verdict> target{};                   // where there is one
  std::optional<Mated> mated{};                      // where it was asked for
  std::optional<WorstTenth> worst{};                 // the same
};

// Takes the results of a campaign one by one, in memory that does not grow with them.
class Tally {
 public:
  void add(const TrialResult& result);
  // Time, force and loss as of Quantiles.
  CampaignSummary summary() const;

 private:
  CampaignSummary counts_{};
  Quantiles time_, force_, loss_;
};
CampaignSummary summarise(const std::vector<TrialResult>& results);

// Of the insertions of trials 0, 1, ... of that scene and seed that succeeded, mated among each
// other (mated_pairs.hpp), with the joint of graded_joint.hpp.
Mated mated(const Scene& scene, const std::vector<TrialResult>& results, std::uint64_t seed);

// Median of a - b over pairs, and its 95 % interval; NaN where there are no pairs, or too few.
struct PairedMedian {
  double median;
  Interval interval;
};

// Two controllers on the same trials, the feasible ones.
struct Comparison {
  double difference;  // success rate of a minus that of b
  Interval interval;  // 95 %, for paired trials
  double mcnemar_p;
  PairedMedian time;        // over the trials in which both inserted [s]
  PairedMedian peak_force;  // [N]
};

// Throws std::invalid_argument unless both have the same number of trials, some of them feasible.
Comparison compare(const std::vector<TrialResult>& a, const std::vector<TrialResult>& b);
// On the first trials, those that both have; empty where none of them is feasible.
std::optional<Comparison> compare_shared(const std::vector<TrialResult>& a,
                                         const std::vector<TrialResult>& b);

}  // namespace ferrule
