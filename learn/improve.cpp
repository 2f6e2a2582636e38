#include "learn/improve.hpp"

#include <algorithm>
#include <cmath>

#include "learn/cma_es.hpp"
#include "sim/base/elementary.hpp"
#include "sim/base/error.hpp"
#include "sim/base/random.hpp"

namespace ferrule {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kFirstSpread = 0.3;
constexpr double kNarrow = 0.02;  // what trials of so many cannot tell apart

// Of the trials of generation `n`; those of a campaign with `seed` itself are never among them.
std::uint64_t seed_of_generation(std::uint64_t seed, std::uint64_t n) {
  return RandomStream(seed, n, "improve").bits() >> 1;
}

// The means of a network's answers, their scales, and the scales of its inputs.
template <class AnyPolicy>
auto& network_number(AnyPolicy& policy, std::size_t i) {
  const auto answers = static_cast<std::size_t>(policy.answers());
  if (i >= 2 * answers) return policy.scale[i - 2 * answers];
  const auto k = static_cast<Index>(i % answers);
  return i < answers ? policy.velocity_mean[k] : policy.velocity_scale[k];
}

// A generation of so many candidates, and then the choice between the centres, its own among them.
std::size_t trials_of(int candidates, std::size_t centres, std::size_t tasks,
                      const ImproveSettings& settings) {
  return tasks * (static_cast<std::size_t>(candidates) * settings.trials_each +
                  (centres + 1) * ImproveCentre::kTrials);
}

// Of the candidates, each in all tasks: the results of the first one's tasks, then of the next one's.
using Results = std::vector<std::vector<TrialResult>>;

// The mean objective of each candidate.
std::vector<double> objectives(const Results& results, const std::vector<ImproveTask>& tasks) {
  std::vector<double> values(results.size() / tasks.size(), 0);
  for (std::size_t i = 0; i < results.size(); ++i)
    values[i / tasks.size()] +=
        tasks[i % tasks.size()].objective.of(results[i]) / static_cast<double>(tasks.size());
  return values;
}

// The trials' parts of the objective of candidate a minus that of b, which is their mean. What is
// drawn is the same in all tasks, so that a trial's differences there go together.
VectorXd objective_differences(const Results& results, const std::vector<ImproveTask>& tasks,
                               std::size_t a, std::size_t b) {
  VectorXd all = VectorXd::Zero(static_cast<Index>(results.front().size()));
  for (std::size_t t = 0; t < tasks.size(); ++t) {
    const auto& in_a = results[a * tasks.size() + t];
    const auto& in_b = results[b * tasks.size() + t];
    const auto feasible = [](const TrialResult& r) { return r.outcome != Outcome::infeasible; };
    const auto count = std::count_if(in_a.begin(), in_a.end(), feasible);
    const double part = static_cast<double>(all.size()) / static_cast<double>(count);
    for (std::size_t k = 0; k < in_a.size(); ++k)
      if (feasible(in_a[k]))
        all[static_cast<Index>(k)] +=
            part * (tasks[t].objective.of(in_a[k]) - tasks[t].objective.of(in_b[k]));
  }
  return all / static_cast<double>(tasks.size());
}

Interval interval_of_mean(const VectorXd& values) {
  const double mean = values.mean(), n = static_cast<double>(values.size());
  const double half =
      two_sided_z() * std::sqrt((values.array() - mean).square().sum() / (n - 1) / n);
  return {mean - half, mean + half};
}

}  // namespace

double Objective::of(const TrialResult& feasible) const {
  if (feasible.outcome != Outcome::inserted) return kFailure;
  return (time > 0 ? feasible.summary.time / time : 0) +
         (force > 0 ? feasible.summary.peak_force / force : 0);
}

double Objective::of(const std::vector<TrialResult>& results) const {
  double sum = 0;
  std::size_t feasible = 0;
  for (const TrialResult& trial : results) {
    if (trial.outcome == Outcome::infeasible) continue;
    ++feasible;
    sum += of(trial);
  }
  return feasible > 0 ? sum / static_cast<double>(feasible) : NAN;
}

double gain(const ControllerFile& controller, std::size_t i) {
  if (const auto* law = std::get_if<LawFile>(&controller)) return law->gains[i].value;
  if (const auto* search = std::get_if<SearchFile>(&controller)) return search->gains[i];
  return network_number(std::get<PolicyFile>(controller).policy, i);
}

std::string gain_name(const ControllerFile& controller, std::size_t i) {
  if (const auto* law = std::get_if<LawFile>(&controller)) return gain_of(law->kind, i).name;
  if (std::holds_alternative<SearchFile>(controller)) return kSearchGains[i].name;
  const Policy& policy = std::get<PolicyFile>(controller).policy;
  const auto answers = static_cast<std::size_t>(policy.answers());
  if (i >= 2 * answers) return policy.channels()[i - 2 * answers].name + std::string(" scale");
  return kPolicyAnswer[i % answers].name + std::string(i < answers ? " mean" : " scale");
}

std::vector<std::size_t> free_gains(const ControllerFile& controller) {
  std::size_t count = kSearchGains.size() - kSearchSizes;
  if (const auto* law = std::get_if<LawFile>(&controller)) count = law->gains.size();
  if (const auto* network = std::get_if<PolicyFile>(&controller))
    count =
        2 * static_cast<std::size_t>(network->policy.answers()) + network->policy.channels().size();
  std::vector<std::size_t> free;
  for (std::size_t i = 0; i < count; ++i)
    if (gain(controller, i) != 0) free.push_back(i);
  return free;
}

ControllerFile with_gains(const ControllerFile& controller, const std::vector<std::size_t>& free,
                          const VectorXd& x) {
  ControllerFile changed = controller;
  for (std::size_t k = 0; k < free.size(); ++k) {
    const double value = gain(controller, free[k]) * elementary::exp(x[static_cast<Index>(k)]);
    if (auto* law = std::get_if<LawFile>(&changed))
      law->gains[free[k]] = {.value = value};
    else if (auto* search = std::get_if<SearchFile>(&changed))
      search->gains[free[k]] = value;
    else
      network_number(std::get<PolicyFile>(changed).policy, free[k]) = value;
  }
  return changed;
}

std::size_t least_trials(const ControllerFile& controller, std::size_t tasks,
                         const ImproveSettings& settings) {
  const auto n = static_cast<Index>(free_gains(controller).size());
  return trials_of(CmaEs::default_population(n), 1, tasks, settings);
}

Improved improve(const ControllerFile& controller, const std::vector<ImproveTask>& tasks,
                 const ImproveSettings& settings,
                 const std::function<void(const ImproveRow&)>& progress,
                 const std::function<bool()>& stop) {
  const std::vector<std::size_t> free = free_gains(controller);
  const auto n = static_cast<Index>(free.size());
  std::uint64_t generation = 0;
  Improved done{controller, {}, {}};
  // All candidates in the same trials; empty where it was stopped.
  const auto tried = [&](const std::vector<VectorXd>& candidates, std::size_t trials) {
    std::vector<Campaign> campaigns;
    for (const VectorXd& x : candidates) {
      const MakeController make = maker(with_gains(controller, free, x));
      for (const ImproveTask& task : tasks) campaigns.push_back({task.scene, make});
    }
    Results results = run_campaigns(campaigns, seed_of_generation(settings.seed, generation++),
                                    trials, settings.threads, {}, stop, settings.kept);
    bool whole = true;
    for (const std::vector<TrialResult>& each : results) {
      done.trials += each.size();
      whole &= each.size() == trials;
    }
    return whole ? results : Results{};
  };

  std::vector<VectorXd> centres = {VectorXd::Zero(n)};
  int population = CmaEs::default_population(n);
  const auto left_for = [&](int candidates) {
    return done.trials + trials_of(candidates, centres.size(), tasks.size(), settings) <=
           settings.trials;
  };
  bool stopped = false;
  for (; !stopped && left_for(population); population *= 2) {
    CmaEs search(VectorXd::Zero(n), kFirstSpread, population, settings.seed + done.restarts);
    while (search.spread() > kNarrow && left_for(population)) {
      const Eigen::MatrixXd& candidates = search.ask();
      std::vector<VectorXd> all;
      for (Index k = 0; k < candidates.cols(); ++k) all.emplace_back(candidates.col(k));
      const std::vector<double> values = objectives(tried(all, settings.trials_each), tasks);
      stopped = values.empty();
      if (stopped) break;
      search.tell(Eigen::Map<const VectorXd>(values.data(), static_cast<Index>(values.size())));
      done.rows.push_back(
          {done.trials, *std::min_element(values.begin(), values.end()), search.spread()});
      if (progress) progress(done.rows.back());
    }
    centres.push_back(search.mean());
    ++done.restarts;
  }
  std::size_t chosen = centres.size() - 1;  // where it was stopped
  if (const Results results = stopped ? Results{} : tried(centres, ImproveCentre::kTrials);
      !results.empty()) {
    const std::vector<double> values = objectives(results, tasks);
    chosen =
        static_cast<std::size_t>(std::min_element(values.begin(), values.end()) - values.begin());
    for (std::size_t i = 0; i < centres.size(); ++i)
      done.choice.push_back({i == 0, i == chosen, values[i],
                             interval_of_mean(objective_differences(results, tasks, i, chosen))});
  }
  done.controller = with_gains(controller, free, centres[chosen]);
  return done;
}

}  // namespace ferrule
