#include "app/compared_learners.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "app/shards.hpp"

namespace ferrule {
namespace {

// " and 30 labelled rollouts", or nothing.
std::string rollouts_text(std::size_t rollouts) {
  return rollouts ? fmt::format(" and {} labelled rollouts", rollouts) : std::string();
}

std::string name_without(const std::string& controller, Ablation what) {
  return controller + ", no " + name(what);
}

// `whole`: the same learner's, with nothing taken away. Empty: there is nothing to take.
std::optional<Candidate> learned_without(const CompareArguments& a, Ablation what,
                                         const DemonstrationSet& set, const ChosenLearner& chosen,
                                         const Candidate& whole) {
  const auto variant = without(what, *chosen.learner, chosen.variant);
  const bool memory = variant && what == Ablation::memory;  // a perceptron's are its samples
  if (what != Ablation::variation && !memory && !has(*whole.file, what)) return {};
  Candidate c = whole;
  if (what == Ablation::variation || variant) {
    ChosenLearner less{chosen.learner, variant.value_or(chosen.variant)};
    less.variant.name = name_without(whole.name, what);
    c = fitted(a, less, without(what, set, a.fit_seed, end_if_interrupted),
               fmt::format("no {}", name(what)));
  }
  c.name = name_without(whole.name, what);
  c.make = without(what, c.make);
  return c;
}

}  // namespace

std::vector<ChosenLearner> chosen_learners(const CompareArguments& a) {
  std::vector<ChosenLearner> chosen;
  for (const Learner& learner : learners())
    for (const Learner::Variant& variant : learner.variants)
      if (a.learners.empty() ||
          std::find(a.learners.begin(), a.learners.end(), variant.key) != a.learners.end())
        chosen.push_back({&learner, variant});
  return chosen;
}

std::vector<std::string> learner_keys() {
  std::vector<std::string> keys;
  for (const ChosenLearner& c : chosen_learners({})) keys.push_back(c.variant.key);
  return keys;
}

Candidate fitted(const CompareArguments& a, const ChosenLearner& chosen,
                 const DemonstrationSet& set, const std::string& which) {
  const std::string what = fmt::format("{} seed {} {}", chosen.variant.key, a.fit_seed, which);
  const TimedController found = learned_once(what, [&] {
    Progress progress(chosen.variant.name, 1);
    ControllerFile controller =
        learned(*chosen.learner, chosen.variant, set, a.fit_seed,
                [&](std::size_t done, std::size_t all, const std::string& note) {
                  progress(done, note, all);
                  return !interrupted();
                });
    end_if_interrupted();
    return controller;
  });
  Candidate c = candidate(chosen.variant.name, found.controller, found.seconds);
  fmt::print(stderr, "{}: fitted to {} demonstrations{} in {:.1f} s\n", c.name,
             set.demonstrations.size(), rollouts_text(c.rollouts), c.fit_seconds);
  return c;
}

std::vector<Climber> ablated(const CompareArguments& a, const DemonstrationSet& set,
                             const std::vector<ChosenLearner>& learned_by,
                             const std::vector<Candidate>& candidates, std::size_t first) {
  std::vector<Climber> all;
  for (const std::string& key : a.ablate) {
    const auto at = std::find(kAblations.begin(), kAblations.end(), key) - kAblations.begin();
    const auto what = static_cast<Ablation>(at);
    for (std::size_t i = first; i < candidates.size(); ++i) {
      const Candidate& whole = candidates[i];
      const std::size_t k = i - first;
      const bool learns = k < learned_by.size();
      try {
        std::optional<Candidate> c;
        if (learns)
          c = learned_without(a, what, set, learned_by[k], whole);
        else if (what != Ablation::variation && (!whole.file || has(*whole.file, what))) {
          c = whole;
          c->name = name_without(whole.name, what);
          c->make = without(what, whole.make);
        }
        if (c) all.push_back({*c, learns ? std::optional(a.fit_seed) : std::nullopt, key});
      } catch (const BadInput& error) {
        end_if_interrupted();
        fmt::print(stderr, "note: {} is left out: {}\n", name_without(whole.name, what),
                   error.what());
      }
    }
  }
  return all;
}

}  // namespace ferrule
