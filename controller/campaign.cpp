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

#include "controller/program_policy.hpp"
#include "controller/trial_fields.hpp"
#include "sim/base/content_hash.hpp"
#include "sim/base/control_period.hpp"
#include "sim/base/error.hpp"

namespace ferrule {

namespace {

std::string fingerprint(const Campaign& campaign, std::uint64_t seed, std::size_t trials) {
  return sha1(campaign.scene->document().dump() + campaign.redrawn + std::to_string(seed) + " " +
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

bool same(const TrialResult& a, const TrialResult& b) {
  return Json::to_cbor(kept_trial(a)) == Json::to_cbor(kept_trial(b));  // NaN is like NaN
}

// The results of a campaign while it runs, taken in the order of the trials.
class Ordered {
 public:
  explicit Ordered(const Campaign& campaign) : campaign_(campaign) {}

  // Is it long enough?
  bool enough() const noexcept { return enough_; }

  // False where trial `k` is known, as far as results are kept, and went differently.
  bool put(std::size_t k, const TrialResult& result) {
    const std::lock_guard lock(mutex_);
    if (enough_) return true;
    if (k < shown_) return k >= results_.size() || same(results_[k], result);
    const auto [at, added] = ahead_.try_emplace(k, result);
    if (!added) return same(at->second, result);
    for (auto next = ahead_.begin(); !enough_ && next != ahead_.end() && next->first == shown_;
         next = ahead_.erase(next), ++shown_) {
      enough_ = campaign_.enough && campaign_.enough(next->second);
      if (campaign_.each) campaign_.each(next->second);
      if (shown_ < campaign_.keep) results_.push_back(std::move(next->second));
    }
    return true;
  }

  std::vector<TrialResult> results() { return std::move(results_); }

 private:
  const Campaign& campaign_;
  std::vector<TrialResult> results_;          // the first ones
  std::map<std::size_t, TrialResult> ahead_;  // of the trials before which one is not done
  std::atomic<bool> enough_ = false;
  std::mutex mutex_;
  std::size_t shown_ = 0;  // to `enough` and `each`
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

}  // namespace

std::vector<std::vector<TrialResult>> run_campaigns(
    const std::vector<Campaign>& campaigns, std::uint64_t seed, std::size_t trials, int threads,
    const std::function<void(std::size_t)>& progress, const std::function<bool()>& stop,
    TrialStore* kept) {
  std::vector<std::vector<TrialResult>> results(campaigns.size());
  const auto stopped = [&] { return stop && stop(); };
  // Which campaign comes after trials that were cut short is not what the other processes run.
  if (campaigns.empty() || stopped()) return results;
  TrialStore nowhere;
  TrialStore& store = kept ? *kept : nowhere;
  const bool enough =
      std::ranges::any_of(campaigns, [](const Campaign& c) { return c.enough != nullptr; });
  const bool tells = enough || store.tells();  // otherwise no result is remembered
  std::deque<Ordered> all;
  std::atomic<std::size_t> count = 0;
  std::vector<TrialStore::Campaign> begun;
  for (std::size_t i = 0; i < campaigns.size(); ++i) {
    all.emplace_back(campaigns[i]);
    begun.push_back({kept ? fingerprint(campaigns[i], seed, trials) : "", trials,
                     [&, i](std::size_t k, const KeptTrial& found) {
                       ++count;
                       const bool agrees = !tells || all[i].put(k, trial_of(found));
                       if (all[i].enough()) store.end(i);
                       return agrees;
                     }});
  }
  store.begin(std::move(begun), enough);
  on_all_cores(threads, [&] {
    while (const auto next = store.next()) {
      if (stopped() || others_ended()) return;
      const auto& [i, k] = *next;
      const auto ends = [&, &one = all[i]] { return one.enough() || stopped(); };
      const TrialResult result = run_trial_of(campaigns[i], seed, k, ends);
      if (ends()) continue;
      store.put(*next, [&] { return kept_trial(result); });
      if (tells) all[i].put(k, result);
      if (all[i].enough()) store.end(i);
      const std::size_t so_far = ++count;
      if (progress) progress(so_far);
    }
  });
  store.done(stop);
  for (std::size_t i = 0; tells && i < all.size(); ++i) results[i] = all[i].results();
  return results;
}

std::vector<TrialResult> run_campaign(const Scene& scene, const MakeController& make,
                                      std::uint64_t seed, std::size_t trials, int threads,
                                      const std::function<void(std::size_t)>& progress,
                                      const std::function<bool()>& stop, const IsEnough& enough,
                                      TrialStore* kept) {
  return run_campaigns({{&scene, make, enough}}, seed, trials, threads, progress, stop, kept)
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
