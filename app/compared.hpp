// What `ferrule compare` finds, and how it is shown: tables, JSON, plots and a page.
#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "app/given_controller.hpp"
#include "app/output.hpp"
#include "app/scene_arguments.hpp"
#include "app/shards.hpp"
#include "app/stopping.hpp"
#include "controller/campaign.hpp"
#include "controller/worst_tenth.hpp"
#include "learn/ablation.hpp"
#include "learn/candidates.hpp"

namespace ferrule {

struct CompareArguments {
  SceneArguments scene;
  std::string folder, plot, trials_out, seeds;
  std::vector<std::string> controllers, transfer, learners, ablate;
  PolicyArguments policy;
  std::vector<std::size_t> demonstrations;
  std::size_t trials = 1000;
  OperatorSkill skill = 0.8;  // of the simulated operator
  std::uint64_t seed = 7, fit_seed = 1;
  int threads = 0;
  bool other_scaling = false, ladder = false, supervise = false;
  StoppingArguments stopping;
  Output output;
  const SharedJob* job = nullptr;
};

inline constexpr const char* kTeacher = "simulated operator";

inline bool asks_for(const CompareArguments& a, Ablation what) {
  return std::find(a.ablate.begin(), a.ablate.end(), name(what)) != a.ablate.end();
}

// A learner with the settings that are compared.
struct ChosenLearner {
  const Learner* learner;
  Learner::Variant variant;
};

// What made a controller of demonstrations.
struct Fit {
  ChosenLearner by;
  std::uint64_t seed;  // of the fit, and where they were recorded again, of that
  std::size_t demonstrations;
};

// A controller that is compared.
struct Compared : Candidate {
  std::optional<Fit> fit{};  // empty: it was not learned here
  std::string without{};     // of kAblations; empty: it is whole
  bool of_scene = false;     // in another scene it is another one
};
// Empty: it does not learn here.
inline std::optional<std::uint64_t> training_seed(const Compared& c) {
  return c.fit ? std::optional(c.fit->seed) : std::nullopt;
}

// Trials whose starts are about as far from the axis: an eighth of all.
struct Ring {
  double from, to;  // distance of the start from the axis [m]
  std::size_t feasible, inserted;
};

// A controller and its trials in the scene of the demonstrations, alone and under the supervisor.
struct Entry : Compared {
  double ns = 0;  // per action
  std::vector<TrialResult> results{}, supervised_results{};
  CampaignSummary alone{}, supervised{};
  std::vector<Ring> rings{};
  std::optional<Comparison>
      against_teacher{};  // empty for the teacher, and without feasible trials
};

// What was learned of fewer demonstrations, or where they were recorded again, and its trials.
struct LearnedAgain : Compared {
  CampaignSummary summary{};
  std::optional<Comparison> against_teacher{};  // of all demonstrations
};

// In another scene.
struct Transfer {
  std::string scene, controller;
  std::optional<std::uint64_t> training_seed;  // empty: it does not learn
  CampaignSummary alone, supervised;
};

// On a rung of data/scenes/ladder.
struct LadderRow {
  std::string rung, controller, without;
  std::optional<std::uint64_t> training_seed;  // empty: it does not learn
  CampaignSummary summary;
  std::optional<CampaignSummary> supervised;  // with --supervise
  WorstTenth worst;
  double search;  // median of InsertionSummary::search_time of the inserted [s]; NaN without any
  Deciding deciding;
};

// Everything that is found, as far as Ctrl-C lets it.
struct Found {
  std::vector<Entry> entries;
  std::vector<LearnedAgain> learning;  // of fewer demonstrations
  std::vector<LearnedAgain> by_seeds;
  std::vector<Transfer> transfer;
  std::vector<LadderRow> ladder;
};

// The tables, in the order in which they are found.
void print_alone(const std::vector<Entry>& entries);
void print_supervised(const std::vector<Entry>& entries);
void print_targets(const std::vector<Entry>& entries);  // where there is one
void print_against_teacher(const std::vector<Entry>& entries);
void print_learning(const std::vector<LearnedAgain>& learning);
void print_by_seeds(const std::vector<LearnedAgain>& all);
void print_transfer(const std::vector<Transfer>& transfer);  // of one scene
void print_ladder(const std::vector<LadderRow>& rung);       // one of them

Json to_json(const CompareArguments& a, const Scene& scene, const DemonstrationSet& set,
             std::size_t trained_starts, const Found& found);

// Plots, and all of them in one page, into the folder `a.plot`; `starts` of the trials [m].
void write_plots(const CompareArguments& a, const Scene& scene, const DemonstrationSet& set,
                 const Found& found, const std::vector<Vector2d>& starts,
                 const Provenance& provenance);

}  // namespace ferrule
