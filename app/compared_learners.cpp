#include "app/compared_learners.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "app/interrupt.hpp"
#include "app/progress.hpp"
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

// Empty: there is nothing to take.
std::optional<Compared> compared_without(const CompareArguments& a, Ablation what,
                                         const DemonstrationSet& set, const Compared& whole) {
  std::optional<Learner::Variant> variant;
  if (whole.fit) variant = without(what, *whole.fit->by.learner, whole.fit->by.variant);
  const bool varies = whole.fit && what == Ablation::variation;
  const bool memory = variant && what == Ablation::memory;  // a perceptron's are its samples
  const bool runs = whole.file ? has(*whole.file, what) : what != Ablation::variation;
  if (!varies && !memory && !runs) return {};
  Compared c = whole;
  c.name = name_without(whole.name, what);
  if (varies || variant) {
    ChosenLearner less{whole.fit->by.learner, variant.value_or(whole.fit->by.variant)};
    less.variant.name = c.name;
    c = fitted(a, less, without(what, set, a.fit_seed, end_if_interrupted),
               fmt::format("no {}", name(what)));
  }
  c.without = name(what);
  c.make = without(what, c.make);
  return c;
}

std::vector<ChosenLearner> chosen_learners(const CompareArguments& a) {
  std::vector<ChosenLearner> chosen;
  for (const Learner& learner : learners())
    for (const Learner::Variant& variant : learner.variants)
      if (a.learners.empty() ||
          std::find(a.learners.begin(), a.learners.end(), variant.key) != a.learners.end())
        chosen.push_back({&learner, variant});
  return chosen;
}

}  // namespace

std::vector<Compared> without_learning(const CompareArguments& a, const Scene& scene,
                                       const DemonstrationSet& set) {
  std::vector<Compared> all;
  for (const Candidate& c : baselines(scene, set, a.skill, a.seed)) all.push_back({c});
  for (const std::string& name : a.controllers)
    if (is_baseline(name)) all.push_back({{.name = name, .make = baseline(name, scene, a.seed)}});
  for (Compared& c : all) c.of_scene = true;
  return all;
}

std::vector<std::string> learner_keys() {
  std::vector<std::string> keys;
  for (const ChosenLearner& c : chosen_learners({})) keys.push_back(c.variant.key);
  return keys;
}

Compared fitted(const CompareArguments& a, const ChosenLearner& chosen, const DemonstrationSet& set,
                const std::string& which) {
  const std::string what = fmt::format("{} seed {} {}", chosen.variant.key, a.fit_seed, which);
  const TimedController found = learned_once(*a.job, what, [&] {
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
  Compared c{candidate(chosen.variant.name, found.controller, found.seconds),
             Fit{chosen, a.fit_seed, set.demonstrations.size()}};
  fmt::print(stderr, "{}: fitted to {} demonstrations{} in {:.1f} s\n", c.name,
             set.demonstrations.size(), rollouts_text(c.rollouts), c.fit_seconds);
  return c;
}

std::vector<Compared> fitted_by_all(const CompareArguments& a, const DemonstrationSet& set) {
  std::vector<Compared> all;
  for (const ChosenLearner& chosen : chosen_learners(a)) {
    const std::string& name = chosen.variant.name;
    try {
      all.push_back(fitted(a, chosen, set, "all"));
    } catch (const BadInput& error) {
      end_if_interrupted();
      if (!a.learners.empty()) throw BadInput(a.folder + ": " + name + ": " + error.what());
      fmt::print(stderr, "note: {} is left out: {}\n", name, error.what());
    }
  }
  return all;
}

std::vector<Compared> ablated(const CompareArguments& a, const DemonstrationSet& set,
                              const Compared& whole) {
  std::vector<Compared> all;
  for (const std::string& key : a.ablate) {
    const auto at = std::find(kAblations.begin(), kAblations.end(), key) - kAblations.begin();
    const auto what = static_cast<Ablation>(at);
    try {
      if (const auto c = compared_without(a, what, set, whole)) all.push_back(*c);
    } catch (const BadInput& error) {
      end_if_interrupted();
      fmt::print(stderr, "note: {} is left out: {}\n", name_without(whole.name, what),
                 error.what());
    }
  }
  return all;
}

}  // namespace ferrule
