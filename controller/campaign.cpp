#include "controller/campaign.hpp"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <deque>
#include <mutex>
#include <stdexcept>
#include <thread>

#include "controller/kept_trial.hpp"
#include "sim/base/content_hash.hpp"

namespace ferrule {

namespace {

// A campaign while it runs: its trials are begun in their order.
class Running {
 public:
  Running(const Campaign& campaign, std::uint64_t seed, std::size_t trials, SharedTrials* shared)
      : campaign_(campaign), shared_(shared), results_(trials), done_(trials, false) {
    if (shared_) number_ = shared_->begin(fingerprint(*campaign.scene, seed, trials), trials);
  }

  // The next trial to be run; empty: none is left.
  std::optional<std::size_t> begin() {
    const std::lock_guard lock(mutex_);
    while (!known_ && next_ < results_.size()) {
      const std::size_t k = next_++;
      if (!shared_ || (!done_[k] && shared_->mine(k))) return k;
    }
    return std::nullopt;
  }

  // Runs it. False where that was ended before the trial was over.
  bool run(std::size_t k, std::uint64_t seed, const std::function<bool()>& stop) {
    const std::function<bool()> ends = [&] { return known_ || (stop && stop()); };
    TrialResult result = run_trial(*campaign_.scene, *campaign_.make(k), seed, k, 1e-3, {}, ends);
    if (ends()) return false;
    if (shared_) shared_->keep(number_, k, kept_trial(result));
    const std::lock_guard lock(mutex_);
    put(k, std::move(result));
    return true;
  }

  // What another process, or this shard before it was killed, has run.
  void take(const SharedTrials::Found& found) {
    const std::lock_guard lock(mutex_);
    if (found.trial >= results_.size()) return;
    if (done_[found.trial])
      shared_->again(found, kept_trial(results_[found.trial]));
    else
      put(found.trial, trial_of(found.result));
  }

  // Of a shared one: the trials that are not there and would count.
  std::vector<std::size_t> missing() const {
    std::vector<std::size_t> trials;
    for (std::size_t k = shown_; !known_ && k < done_.size(); ++k)
      if (!done_[k]) trials.push_back(k);
    return trials;
  }

  // Those that are missing count as infeasible.
  void fill() {
    for (const std::size_t k : missing()) {
      results_[k].outcome = Outcome::infeasible;
      done_[k] = true;
    }
    if (!known_) shown_ = results_.size();
  }

  std::vector<TrialResult> results() {
    results_.resize(shown_);
    return std::move(results_);
  }

  std::size_t number() const { return number_; }

 private:
  static std::string fingerprint(const Scene& scene, std::uint64_t seed, std::size_t trials) {
    return sha1(scene.document.dump() + scene.redrawn + std::to_string(seed) + " " +
                std::to_string(trials));
  }

  void put(std::size_t k, TrialResult result) {
    results_[k] = std::move(result);
    done_[k] = true;
    while (!known_ && shown_ < results_.size() && done_[shown_]) {
      const TrialResult& next = results_[shown_++];
      known_ = campaign_.enough && campaign_.enough(next);
    }
  }

  const Campaign& campaign_;
  SharedTrials* shared_;
  std::size_t number_ = 0;  // of it among those that are shared
  std::vector<TrialResult> results_;
  std::vector<char> done_;
  std::atomic<bool> known_ = false;
  std::mutex mutex_;
  std::size_t next_ = 0, shown_ = 0;  // shown_: to `enough`
};

// Does what comes next depend on what other shards have run?
bool looks_around(const SharedTrials& shared, const std::vector<Campaign>& campaigns) {
  return shared.waits() || std::any_of(campaigns.begin(), campaigns.end(),
                                       [](const Campaign& c) { return c.enough != nullptr; });
}

// What was run before, here or elsewhere, and is new; and how many trials that is.
std::size_t take_found(SharedTrials& shared, std::deque<Running>& all) {
  const std::vector<SharedTrials::Found> found = shared.found(all.front().number());
  for (const SharedTrials::Found& one : found) all[one.campaign - all.front().number()].take(one);
  return found.size();
}

// Waits for what is missing, refuses it, or fills it in.
void complete(SharedTrials& shared, std::deque<Running>& all, const std::function<bool()>& stop) {
  constexpr auto kBetweenLooks = std::chrono::milliseconds(500);
  for (Running& one : all) {
    while (shared.waits() && !one.missing().empty() && !(stop && stop())) {
      std::this_thread::sleep_for(kBetweenLooks);
      shared.look_around();
      take_found(shared, all);
    }
    if (const auto missing = one.missing(); shared.merges() && !missing.empty())
      shared.refuse_missing(one.number(), missing);
    if (!stop || !stop()) one.fill();
  }
}

}  // namespace

std::vector<std::vector<TrialResult>> run_campaigns(
    const std::vector<Campaign>& campaigns, std::uint64_t seed, std::size_t trials, int threads,
    const std::function<void(std::size_t)>& progress, const std::function<bool()>& stop,
    SharedTrials* shared) {
  std::deque<Running> all;
  for (const Campaign& campaign : campaigns) all.emplace_back(campaign, seed, trials, shared);
  const bool looks = shared && looks_around(*shared, campaigns);
  std::atomic<std::size_t> count = 0;
  if (shared && !all.empty()) {
    if (looks) shared->look_around();
    count += take_found(*shared, all);
  }
  const auto work = [&](int) {
    for (Running& one : all)
      while (const auto k = one.begin()) {
        if (stop && stop()) return;
        if (!one.run(*k, seed, stop)) continue;
        const std::size_t so_far = ++count;
        if (progress) progress(so_far);
        if (looks && shared->wrote()) {
          shared->look_around();
          count += take_found(*shared, all);
        }
      }
  };
  tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
  arena.execute(
      [&] { tbb::parallel_for(0, arena.max_concurrency(), work, tbb::simple_partitioner()); });
  if (shared && !all.empty()) {
    shared->flush();
    complete(*shared, all, stop);
  }
  std::vector<std::vector<TrialResult>> results;
  for (Running& one : all) results.push_back(one.results());
  return results;
}

std::vector<TrialResult> run_campaign(const Scene& scene, const MakeController& make,
                                      std::uint64_t seed, std::size_t trials, int threads,
                                      const std::function<void(std::size_t)>& progress,
                                      const std::function<bool()>& stop, const IsEnough& enough,
                                      SharedTrials* shared) {
  return run_campaigns({{&scene, make, enough}}, seed, trials, threads, progress, stop, shared)
      .front();
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
