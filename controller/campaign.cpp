#include "controller/campaign.hpp"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <deque>
#include <mutex>
#include <stdexcept>

namespace ferrule {

namespace {

// A campaign while it runs: its trials are begun in their order.
class Running {
 public:
  Running(const Campaign& campaign, std::size_t trials)
      : campaign_(campaign), results_(trials), done_(trials, false) {}

  // The next trial to be run; empty: none is left.
  std::optional<std::size_t> begin() {
    if (known_) return std::nullopt;
    const std::size_t k = next_++;
    return k < results_.size() ? std::optional(k) : std::nullopt;
  }

  // Runs it. False where that was ended before the trial was over.
  bool run(std::size_t k, std::uint64_t seed, const std::function<bool()>& stop) {
    const std::function<bool()> ends = [&] { return known_ || (stop && stop()); };
    TrialResult result = run_trial(*campaign_.scene, *campaign_.make(k), seed, k, 1e-3, {}, ends);
    if (ends()) return false;
    const std::lock_guard lock(mutex_);
    results_[k] = std::move(result);
    done_[k] = true;
    while (!known_ && shown_ < results_.size() && done_[shown_]) {
      const TrialResult& next = results_[shown_++];
      known_ = campaign_.enough && campaign_.enough(next);
    }
    return true;
  }

  std::vector<TrialResult> results() {
    results_.resize(shown_);
    return std::move(results_);
  }

 private:
  const Campaign& campaign_;
  std::vector<TrialResult> results_;
  std::vector<char> done_;
  std::atomic<std::size_t> next_ = 0;
  std::atomic<bool> known_ = false;
  std::mutex mutex_;
  std::size_t shown_ = 0;  // to `enough`
};

}  // namespace

std::vector<std::vector<TrialResult>> run_campaigns(
    const std::vector<Campaign>& campaigns, std::uint64_t seed, std::size_t trials, int threads,
    const std::function<void(std::size_t)>& progress, const std::function<bool()>& stop) {
  std::deque<Running> all;
  for (const Campaign& campaign : campaigns) all.emplace_back(campaign, trials);
  std::atomic<std::size_t> count = 0;
  const auto work = [&](int) {
    for (Running& one : all)
      while (const auto k = one.begin()) {
        if (stop && stop()) return;
        if (!one.run(*k, seed, stop)) continue;
        const std::size_t so_far = ++count;
        if (progress) progress(so_far);
      }
  };
  tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
  arena.execute(
      [&] { tbb::parallel_for(0, arena.max_concurrency(), work, tbb::simple_partitioner()); });
  std::vector<std::vector<TrialResult>> results;
  for (Running& one : all) results.push_back(one.results());
  return results;
}

std::vector<TrialResult> run_campaign(const Scene& scene, const MakeController& make,
                                      std::uint64_t seed, std::size_t trials, int threads,
                                      const std::function<void(std::size_t)>& progress,
                                      const std::function<bool()>& stop, const IsEnough& enough) {
  return run_campaigns({{&scene, make, enough}}, seed, trials, threads, progress, stop).front();
}

namespace {

void count(const Supervision& trial, std::optional<InterventionSummary>& sum) {
  if (!sum) sum.emplace();
  bool any = false;
  for (std::size_t i = 0; i < kInterventions; ++i) {
    const std::size_t n = trial.interventions[i];
    sum->kinds[i].count += n;
    sum->kinds[i].trials += n > 0;
    any |= n > 0;
  }
  sum->trials += any;
  if (trial.gave_up) ++sum->gave_up[static_cast<std::size_t>(*trial.gave_up)];
}

}  // namespace

CampaignSummary summarise(const std::vector<TrialResult>& results) {
  CampaignSummary s{};
  s.trials = results.size();
  std::vector<double> time, force, loss;
  for (const TrialResult& r : results) {
    ++s.outcomes[static_cast<std::size_t>(r.outcome)];
    if (r.supervision) count(*r.supervision, s.interventions);
    if (r.outcome == Outcome::infeasible) continue;
    ++s.feasible;
    s.steps += r.summary.steps;
    s.unfinished += r.summary.unfinished;
    force.push_back(r.summary.peak_force);
    if (r.outcome != Outcome::inserted) continue;
    time.push_back(r.summary.time);
    loss.push_back(r.loss_dB);
  }
  s.successes = time.size();
  s.success_rate = static_cast<double>(s.successes) / static_cast<double>(s.feasible);
  s.wilson = s.feasible > 0 ? wilson(s.successes, s.feasible) : Interval{0, 1};
  const auto spread = [](const std::vector<double>& v) {
    return Spread{quantile(v, 0.5), quantile(v, 0.95)};
  };
  s.time = spread(time);
  s.peak_force = spread(force);
  s.loss_dB = spread(loss);
  return s;
}

Mated mated(const Joint& joint, const std::vector<TrialResult>& results, std::uint64_t seed) {
  std::vector<LightAxis> inserted;
  for (const TrialResult& r : results)
    if (r.outcome == Outcome::inserted) inserted.push_back(r.light);
  return {mate(joint, inserted, seed, false), mate(joint, inserted, seed, true)};
}

Comparison compare(const std::vector<TrialResult>& a, const std::vector<TrialResult>& b) {
  if (a.size() != b.size())
    throw std::invalid_argument("compare: both must have the same number of trials");
  std::size_t only_a = 0, only_b = 0, feasible = 0;
  std::vector<double> time, force;
  for (std::size_t k = 0; k < a.size(); ++k) {
    if (a[k].outcome == Outcome::infeasible) continue;
    ++feasible;
    const bool in_a = a[k].outcome == Outcome::inserted, in_b = b[k].outcome == Outcome::inserted;
    only_a += in_a && !in_b;
    only_b += in_b && !in_a;
    if (in_a && in_b) time.push_back(a[k].summary.time - b[k].summary.time);
    force.push_back(a[k].summary.peak_force - b[k].summary.peak_force);
  }
  if (feasible == 0) throw std::invalid_argument("compare: no trial is feasible");
  const double n = static_cast<double>(feasible);
  const double count_a = static_cast<double>(only_a), count_b = static_cast<double>(only_b);
  // Bonett and Price 2012: Wald's interval with one discordant pair added on either side.
  const double p_a = (count_a + 1) / (n + 2), p_b = (count_b + 1) / (n + 2), d = p_a - p_b;
  const double half = 1.959963984540054 * std::sqrt((p_a + p_b - d * d) / (n + 2));
  const auto paired = [](const std::vector<double>& differences) {
    return PairedMedian{quantile(differences, 0.5), median_interval(differences)};
  };
  return {(count_a - count_b) / n,
          {std::max(-1.0, d - half), std::min(1.0, d + half)},
          mcnemar_p(only_a, only_b),
          paired(time),
          paired(force)};
}

std::optional<Comparison> compare_shared(const std::vector<TrialResult>& a,
                                         const std::vector<TrialResult>& b) {
  const auto count = static_cast<std::ptrdiff_t>(std::min(a.size(), b.size()));
  const std::vector<TrialResult> first(a.begin(), a.begin() + count);
  if (summarise(first).feasible == 0) return std::nullopt;
  return compare(first, {b.begin(), b.begin() + count});
}

}  // namespace ferrule
