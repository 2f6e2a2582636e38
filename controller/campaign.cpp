#include "controller/campaign.hpp"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <deque>
#include <map>
#include <mutex>
#include <stdexcept>
#include <thread>

#include "controller/kept_trial.hpp"
#include "controller/program_policy.hpp"
#include "sim/base/content_hash.hpp"
#include "sim/base/control_period.hpp"
#include "sim/base/error.hpp"

namespace ferrule {

namespace {

std::string fingerprint(const Campaign& campaign, std::uint64_t seed, std::size_t trials) {
  return sha1(campaign.scene->document.dump() + campaign.redrawn + std::to_string(seed) + " " +
              std::to_string(trials));
}

// Trial `k`; again where the system ended its policy, which says nothing of the trial.
TrialResult run_trial_of(const Campaign& campaign, std::uint64_t seed, std::size_t k,
                         const std::function<bool()>& stop) {
  constexpr int kTries = 3;
  for (int i = 1;; ++i) {
    TrialResult result = run_trial(*campaign.scene, *campaign.make(k), seed, k, kControlPeriod, {},
                                   stop, campaign.redrawn);
    if (!ended_by_system(result.why) || (stop && stop())) return result;
    if (i == kTries)
      throw BadInput(fmt::format("trial {}: {}, each of {} times: is there enough memory?", k,
                                 result.why, kTries));
  }
}

// A campaign while it runs: its trials are begun in their order, and its results taken in it.
class Running {
 public:
  Running(const Campaign& campaign, std::uint64_t seed, std::size_t trials, SharedTrials* shared)
      : campaign_(campaign), shared_(shared), trials_(trials) {
    if (shared_) number_ = shared_->begin(fingerprint(campaign, seed, trials), trials);
  }

  // The next trial to be run; empty: none is left.
  std::optional<std::size_t> begin() {
    const std::lock_guard lock(mutex_);
    while (!known_ && next_ < trials_) {
      const std::size_t k = next_++;
      if (!shared_ || (!done(k) && shared_->mine(k))) return k;
    }
    return std::nullopt;
  }

  // Runs it. False where that was ended before the trial was over.
  bool run(std::size_t k, std::uint64_t seed, const std::function<bool()>& stop) {
    const std::function<bool()> ends = [&] { return known_ || (stop && stop()); };
    TrialResult result = run_trial_of(campaign_, seed, k, ends);
    if (ends()) return false;
    if (shared_) shared_->keep(number_, k, kept_trial(result));
    const std::lock_guard lock(mutex_);
    put(k, std::move(result));
    return true;
  }

  // What another process, or this shard before it was killed, has run.
  void take(const SharedTrials::Found& found) {
    const std::lock_guard lock(mutex_);
    if (known_ || found.trial >= trials_) return;
    if (!done(found.trial)) return put(found.trial, trial_of(found.result));
    const auto ahead = ahead_.find(found.trial);
    const TrialResult* before = ahead != ahead_.end() ? &ahead->second : nullptr;
    if (found.trial < results_.size()) before = &results_[found.trial];
    shared_->again(found, before ? kept_trial(*before) : found.result);  // else it is not kept
  }

  // Of a shared one: the trials that are not there and would count.
  std::vector<std::size_t> missing() const {
    std::vector<std::size_t> trials;
    for (std::size_t k = shown_; !known_ && k < trials_; ++k)
      if (!done(k)) trials.push_back(k);
    return trials;
  }

  std::vector<TrialResult> results() { return std::move(results_); }

  std::size_t number() const { return number_; }

 private:
  bool done(std::size_t k) const { return k < shown_ || ahead_.contains(k); }

  void put(std::size_t k, TrialResult result) {
    ahead_.emplace(k, std::move(result));
    for (auto next = ahead_.begin(); !known_ && next != ahead_.end() && next->first == shown_;
         next = ahead_.erase(next), ++shown_) {
      known_ = campaign_.enough && campaign_.enough(next->second);
      if (campaign_.each) campaign_.each(next->second);
      if (shown_ < campaign_.keep) results_.push_back(std::move(next->second));
    }
  }

  const Campaign& campaign_;
  SharedTrials* shared_;
  std::size_t trials_, number_ = 0;           // number_: of it among those that are shared
  std::vector<TrialResult> results_;          // the first ones
  std::map<std::size_t, TrialResult> ahead_;  // of the trials before which one is not done
  std::atomic<bool> known_ = false;
  std::mutex mutex_;
  std::size_t next_ = 0, shown_ = 0;  // shown_: to `enough` and `each`
};

// Has one of the cores thrown what ends all?
bool others_ended() {
  return tbb::is_current_task_group_canceling();
}

// Calls `work` on every core; where it throws on one, those end that ask others_ended().
void on_all_cores(int threads, const std::function<void()>& work) {
  tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
  arena.execute([&] {
    tbb::parallel_for(
        0, arena.max_concurrency(), [&](int) { work(); }, tbb::simple_partitioner());
  });
}

// A shard for which it makes no difference what the others run.
bool stands_alone(const SharedTrials& shared, const std::vector<Campaign>& campaigns) {
  return !shared.merges() && !shared.waits() &&
         std::none_of(campaigns.begin(), campaigns.end(),
                      [](const Campaign& c) { return c.enough != nullptr; });
}

// The trials of a shard that needs no others, of which it remembers none.
void run_alone(const std::vector<Campaign>& campaigns, std::uint64_t seed, std::size_t trials,
               int threads, const std::function<void(std::size_t)>& progress,
               const std::function<bool()>& stop, SharedTrials& shared) {
  std::vector<std::size_t> numbers;
  for (const Campaign& campaign : campaigns)
    numbers.push_back(shared.begin(fingerprint(campaign, seed, trials), trials));
  if (campaigns.empty()) return;
  const std::size_t own = shared.own_of(trials);
  std::vector<bool> kept(own * campaigns.size());  // from before, one campaign after the other
  std::atomic<std::size_t> next = 0, count = 0;
  shared.found(numbers.front(), [&](const SharedTrials::Found& found) {
    if (!shared.mine(found.trial) || found.trial >= trials) return;
    const std::size_t i = (found.campaign - numbers.front()) * own + shared.own_place(found.trial);
    count += !kept[i];
    kept[i] = true;
  });
  on_all_cores(threads, [&] {
    for (std::size_t i; (i = next++) < own * campaigns.size();) {
      const Campaign& campaign = campaigns[i / own];
      const std::size_t number = numbers[i / own], k = shared.own_trial(i % own);
      if (kept[i]) continue;
      if ((stop && stop()) || others_ended()) return;
      const TrialResult result = run_trial_of(campaign, seed, k, stop);
      if (stop && stop()) return;
      shared.keep(number, k, kept_trial(result));
      const std::size_t so_far = ++count;
      if (progress) progress(so_far);
    }
  });
  shared.flush();
}

// What was run before, here or elsewhere, and is new; and how many trials that is.
std::size_t take_found(SharedTrials& shared, std::deque<Running>& all) {
  const std::size_t first = all.front().number();
  return shared.found(
      first, [&](const SharedTrials::Found& found) { all[found.campaign - first].take(found); });
}

// Waits for what others have not run yet, or in a merge refuses that.
void complete(SharedTrials& shared, std::deque<Running>& all, const std::function<bool()>& stop) {
  constexpr auto kBetweenLooks = std::chrono::milliseconds(500);
  for (Running& one : all) {
    if (const auto missing = one.missing(); shared.merges() && !missing.empty())
      shared.refuse_missing(one.number(), missing);
    while (shared.waits() && !one.missing().empty() && !(stop && stop())) {
      std::this_thread::sleep_for(kBetweenLooks);
      shared.look_around();
      take_found(shared, all);
    }
  }
}

}  // namespace

std::vector<std::vector<TrialResult>> run_campaigns(
    const std::vector<Campaign>& campaigns, std::uint64_t seed, std::size_t trials, int threads,
    const std::function<void(std::size_t)>& progress, const std::function<bool()>& stop,
    SharedTrials* shared) {
  // Which campaign comes after trials that were cut short is not what the other processes run.
  if (shared && stop && stop()) return std::vector<std::vector<TrialResult>>(campaigns.size());
  if (shared && stands_alone(*shared, campaigns)) {
    run_alone(campaigns, seed, trials, threads, progress, stop, *shared);
    return std::vector<std::vector<TrialResult>>(campaigns.size());
  }
  std::deque<Running> all;
  for (const Campaign& campaign : campaigns) all.emplace_back(campaign, seed, trials, shared);
  if (all.empty()) return {};
  std::atomic<std::size_t> count = 0;
  if (shared) {
    if (!shared->merges()) shared->look_around();  // a merge has read all
    count += take_found(*shared, all);
  }
  on_all_cores(threads, [&] {
    for (Running& one : all)
      while (const auto k = one.begin()) {
        if ((stop && stop()) || others_ended()) return;
        if (!one.run(*k, seed, stop)) continue;
        const std::size_t so_far = ++count;
        if (progress) progress(so_far);
        if (shared && shared->wrote()) {
          shared->look_around();
          count += take_found(*shared, all);
        }
      }
  });
  if (shared) {
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

void Tally::add(const TrialResult& r) {
  CampaignSummary& s = counts_;
  ++s.trials;
  ++s.outcomes[static_cast<std::size_t>(r.outcome)];
  if (r.supervision) count(*r.supervision, s.interventions);
  if (r.outcome == Outcome::infeasible) return;
  ++s.feasible;
  s.steps += r.summary.steps;
  s.unfinished += r.summary.unfinished;
  force_.add(r.summary.peak_force);
  if (r.outcome != Outcome::inserted) return;
  time_.add(r.summary.time);
  loss_.add(r.loss_dB);
}

CampaignSummary Tally::summary() const {
  CampaignSummary s = counts_;
  s.successes = time_.count();
  s.success_rate = static_cast<double>(s.successes) / static_cast<double>(s.feasible);
  s.wilson = s.feasible > 0 ? wilson(s.successes, s.feasible) : Interval{0, 1};
  const auto spread = [](const Quantiles& of) { return Spread{of(0.5), of(0.95)}; };
  s.time = spread(time_);
  s.peak_force = spread(force_);
  s.loss_dB = spread(loss_);
  return s;
}

CampaignSummary summarise(const std::vector<TrialResult>& results) {
  Tally tally;
  for (const TrialResult& r : results) tally.add(r);
  return tally.summary();
}

Mated mated(const Scene& scene, const std::vector<TrialResult>& results, std::uint64_t seed) {
  Mated all{
      .untuned = {}, .tuned = {}, .untuned_at = {}, .tuned_at = {}, .joint = graded_joint(scene)};
  std::vector<LightAxis> inserted;
  for (std::size_t k = 0; k < results.size(); ++k) {
    if (results[k].outcome != Outcome::inserted) continue;
    inserted.push_back(results[k].light);
    inserted.back().offset += all.joint.unstated_offset(seed, k);
  }
  for (const Joint& at : all.joint.at) {
    all.untuned_at.push_back(mate(at, inserted, seed, false));
    all.tuned_at.push_back(mate(at, inserted, seed, true));
  }
  all.untuned = worst_of(all.untuned_at);
  all.tuned = worst_of(all.tuned_at);
  return all;
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
  const double half = two_sided_z() * std::sqrt((p_a + p_b - d * d) / (n + 2));
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
