#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/compared.hpp"
#include "app/damage.hpp"
#include "controller/campaign_table.hpp"
#include "controller/supervisor.hpp"
#include "insertion/scene_scaling.hpp"

namespace ferrule {
namespace {

// A number of a table; a dash where there is none.
std::string cell(double x, int digits) {
  return std::isfinite(x) ? fmt::format("{:.{}f}", x, digits) : "-";
}

std::string success_text(const CampaignSummary& s) {
  return s.feasible > 0 ? fmt::format("{:5.1f} ({:.1f} to {:.1f})", 100 * s.success_rate,
                                      100 * s.wilson.low, 100 * s.wilson.high)
                        : "-";
}

std::string outcome_columns(const CampaignSummary& s) {
  return fmt::format(" {:>22} {:>8} {:>9}", success_text(s), cell(s.time.median, 2),
                     cell(1e6 * s.peak_force.median, 2));
}
constexpr const char* kOutcomeColumns = "  inserted [%], 95 %     time [s] peak [uN]";

// The rows that are the same but for the seed of training, in the order of the first of each.
template <class Row, class Same>
std::vector<std::vector<Row>> over_seeds(const std::vector<Row>& rows, Same same) {
  std::vector<std::vector<Row>> groups;
  for (const Row& row : rows) {
    const auto group = std::find_if(groups.begin(), groups.end(),
                                    [&](const auto& g) { return same(g.front(), row); });
    if (group == groups.end())
      groups.push_back({row});
    else
      group->push_back(row);
  }
  return groups;
}

// The worst and the median by success, then by time; of one it, twice.
std::pair<CampaignSummary, CampaignSummary> worst_and_median(std::vector<CampaignSummary> all) {
  std::sort(all.begin(), all.end(), [](const CampaignSummary& a, const CampaignSummary& b) {
    return std::pair(a.success_rate, -a.time.median) < std::pair(b.success_rate, -b.time.median);
  });
  return {all.front(), all[(all.size() - 1) / 2]};
}

Json to_json(const Entry& e, const Output& output) {
  Json row = {{"controller", e.name},
              {"parameters", e.parameters},
              {"labelled_rollouts", e.rollouts},
              {"fit_s", number_or_null(e.fit_seconds)},
              {"held_out_mm_s", number_or_null(1e3 * e.held_out.value_or(NAN))},
              {"ns_per_action", e.ns},
              {"supervised", to_json(e.supervised)}};
  row.update(to_json(e.alone));
  add_failures(e.results, output, row);
  if (e.name != kTeacher) {
    constexpr Interval kNone{NAN, NAN};
    const Comparison none{NAN, kNone, NAN, {NAN, kNone}, {NAN, kNone}};
    row["against_operator"] = Json::object();
    add_json(e.against_teacher.value_or(none), row["against_operator"]);
  }
  row["misalignment"] = Json::array();
  for (const Ring& ring : e.rings)
    row["misalignment"].push_back({{"from_um", 1e6 * ring.from},
                                   {"to_um", 1e6 * ring.to},
                                   {"feasible", ring.feasible},
                                   {"inserted", ring.inserted}});
  return row;
}

Json learning_json(const LearnedAgain& l) {
  Json row = {{"controller", l.name},
              {"training_seed", l.fit->seed},
              {"demonstrations", l.fit->demonstrations},
              {"labelled_rollouts", l.rollouts}};
  row.update(to_json(l.summary));
  return row;
}

Json by_seed_json(const LearnedAgain& l) {
  Json row = {{"controller", l.name},
              {"seed", l.fit->seed},
              {"demonstrations", l.fit->demonstrations},
              {"labelled_rollouts", l.rollouts},
              {"fit_s", l.fit_seconds},
              {"held_out_mm_s", number_or_null(1e3 * l.held_out.value_or(NAN))}};
  row.update(to_json(l.summary));
  if (l.against_teacher) {
    row["against_operator"] = Json::object();
    add_json(*l.against_teacher, row["against_operator"]);
  }
  return row;
}

Json to_json(const Transfer& t) {
  Json row = {{"scene", t.scene},
              {"controller", t.controller},
              {"training_seed", t.training_seed ? Json(*t.training_seed) : Json()},
              {"supervised", to_json(t.supervised)}};
  row.update(to_json(t.alone));
  return row;
}

Json to_json(const LadderRow& r) {
  Json row = {
      {"rung", r.rung},
      {"controller", r.controller},
      {"without", r.without.empty() ? Json() : Json(r.without)},
      {"training_seed", r.training_seed ? Json(*r.training_seed) : Json()},
      {"trials", r.summary.trials},
      {"success_rate", number_or_null(r.summary.success_rate)},
      {"wilson_low", number_or_null(r.summary.wilson.low)},
      {"wilson_high", number_or_null(r.summary.wilson.high)},
      {"decided_by", {{"key", r.deciding.name}, {"share", number_or_null(r.deciding.share)}}},
      {"time_s", number_or_null(r.summary.time.median)},
      {"search_s", number_or_null(r.search)},
      {"peak_force_uN", number_or_null(1e6 * r.summary.peak_force.median)}};
  add_json(r.worst, row);
  if (r.supervised) row["supervised"] = to_json(*r.supervised);
  return row;
}

}  // namespace

void print_alone(const std::vector<Entry>& entries) {
  fmt::print("{:<26} {:>5} {:>7} {:>9} {:>7}{} {:>9} {:>7} {:>7}\n", "", "param", "fit [s]",
             "held out", "ns", kOutcomeColumns, "loss [dB]", "to 99 %", "99.9 %");
  for (const Entry& e : entries) {
    const bool learned = e.parameters > 0;
    fmt::print("{:<26} {:>5} {:>7} {:>9} {:>7.0f}{} {:>9} {:>7} {:>7}\n", e.name,
               learned ? std::to_string(e.parameters) : "-", cell(learned ? e.fit_seconds : NAN, 2),
               cell(1e3 * e.held_out.value_or(NAN), 4), e.ns, outcome_columns(e.alone),
               cell(e.alone.loss_dB.median, 4), trials_to_show_or("-", 0.99, e.alone),
               trials_to_show_or("-", 0.999, e.alone));
  }
  fmt::print(
      "held out: velocity error on held-out demonstrations [mm/s, hand]; ns: per action;\n"
      "time and loss: medians of the inserted, peak force: median of all;\n"
      "to 99 %, 99.9 %: further trials that would show it at this rate; -: none would\n");
  for (const Entry& e : entries)
    if (const std::string note = time_limit_note(e.alone); !note.empty())
      fmt::print("{}: {}\n", e.name, note);
  fmt::print("\n");
}

void print_supervised(const std::vector<Entry>& entries) {
  fmt::print(
      "the same under the supervisor, and how often it intervened\n{:<26}{} {:>7} {:>7} {:>7} "
      "{:>8}\n",
      "", kOutcomeColumns, "held", "jam", "retreat", "gave up");
  for (const Entry& e : entries) {
    if (!e.supervised.interventions) continue;
    const auto count = [&](Intervention kind) {
      return e.supervised.interventions->kinds[static_cast<std::size_t>(kind)].count;
    };
    fmt::print("{:<26}{} {:>7} {:>7} {:>7} {:>8}\n", e.name, outcome_columns(e.supervised),
               count(Intervention::held), count(Intervention::jam), count(Intervention::retreat),
               e.supervised.outcomes[static_cast<std::size_t>(Outcome::gave_up)]);
  }
}

void print_targets(const std::vector<Entry>& entries) {
  if (entries.empty() || !entries.front().alone.target) return;
  fmt::print("\n{:<26} {:<36} {}\n", "target", "alone", "supervised");
  for (const Entry& e : entries)
    fmt::print("{:<26} {:<36} {}\n", e.name, to_text(*e.alone.target),
               to_text(*e.supervised.target));
}

void print_against_teacher(const std::vector<Entry>& entries) {
  fmt::print("\n{:<26} {:>26} {:>9} {:>23} {:>23}\n", fmt::format("minus {}", kTeacher),
             "inserted [points], 95 %", "McNemar p", "time [s], 95 %", "peak [uN], 95 %");
  for (const Entry& e : entries) {
    if (!e.against_teacher) continue;
    const Comparison& d = *e.against_teacher;
    const auto paired = [](const PairedMedian& p, double unit) {
      return fmt::format("{} ({} to {})", cell(unit * p.median, 2), cell(unit * p.interval.low, 2),
                         cell(unit * p.interval.high, 2));
    };
    fmt::print("{:<26} {:>26} {:>9.2g} {:>23} {:>23}\n", e.name,
               fmt::format("{:+.1f} ({:+.1f} to {:+.1f})", 100 * d.difference, 100 * d.interval.low,
                           100 * d.interval.high),
               d.mcnemar_p, paired(d.time, 1), paired(d.peak_force, 1e6));
  }
  fmt::print("of the same trials, alone; time and peak force: medians of the differences\n");
  std::fflush(stdout);  // what follows takes long, and may be ended by Ctrl-C
}

// Lowest, median and highest over the seeds.
void print_by_seeds(const std::vector<LearnedAgain>& all) {
  if (all.empty()) return;
  fmt::print("\n{:<26} {:>5} {:>31} {:>29}\n", "over seeds", "seeds",
             "inserted [%], median (range)", "time [s], median (range)");
  const auto same = [](const LearnedAgain& a, const LearnedAgain& b) { return a.name == b.name; };
  for (const std::vector<LearnedAgain>& of : over_seeds(all, same)) {
    std::vector<double> inserted, time;
    for (const LearnedAgain& each : of) {
      inserted.push_back(100 * each.summary.success_rate);
      time.push_back(each.summary.time.median);
    }
    const auto spread = [](const std::vector<double>& v, int digits) {
      return fmt::format("{} ({} to {})", cell(quantile(v, 0.5), digits),
                         cell(quantile(v, 0), digits), cell(quantile(v, 1), digits));
    };
    fmt::print("{:<26} {:>5} {:>31} {:>29}\n", of.front().name, of.size(), spread(inserted, 1),
               spread(time, 2));
  }
  fmt::print("each seed records the demonstrations and fits again; the trials are the same\n");
}

void print_learning(const std::vector<LearnedAgain>& learning) {
  if (learning.empty()) return;
  const auto same = [](const LearnedAgain& a, const LearnedAgain& b) {
    return a.name == b.name && a.fit->demonstrations == b.fit->demonstrations;
  };
  const std::vector<std::vector<LearnedAgain>> groups = over_seeds(learning, same);
  const bool seeds = groups.size() < learning.size();
  fmt::print("\n{:<26} {:>7}{}{}\n", "from fewer demonstrations", "", kOutcomeColumns,
             seeds ? kOutcomeColumns : "");
  for (const std::vector<LearnedAgain>& group : groups) {
    const LearnedAgain& l = group.front();
    std::vector<CampaignSummary> summaries;
    for (const LearnedAgain& each : group) summaries.push_back(each.summary);
    const auto [worst, median] = worst_and_median(summaries);
    fmt::print("{:<26} {:>7}{}{}\n", l.name,
               l.rollouts ? fmt::format("{}+{}", l.fit->demonstrations, l.rollouts)
                          : std::to_string(l.fit->demonstrations),
               outcome_columns(worst), seeds ? outcome_columns(median) : "");
  }
  if (seeds) fmt::print("the worst of the seeds, and their median\n");
  if (std::any_of(learning.begin(), learning.end(),
                  [](const LearnedAgain& l) { return l.rollouts; }))
    fmt::print("5+30: 5 demonstrations and 30 rollouts of its own, labelled by the operator\n");
}

// Of one scene.
void print_transfer(const std::vector<Transfer>& transfer) {
  if (transfer.empty()) return;
  fmt::print("\n{:<26}{}{}\n", fmt::format("in {}; right: supervised", transfer.front().scene),
             kOutcomeColumns, kOutcomeColumns);
  const auto same = [](const Transfer& a, const Transfer& b) {
    return a.controller == b.controller;
  };
  const std::vector<std::vector<Transfer>> groups = over_seeds(transfer, same);
  for (const std::vector<Transfer>& of : groups) {
    std::vector<CampaignSummary> alone, supervised;
    for (const Transfer& t : of) {
      alone.push_back(t.alone);
      supervised.push_back(t.supervised);
    }
    const std::string& name = of.front().controller;
    const CampaignSummary& first = alone.front();
    const auto [worst, median] = worst_and_median(alone);
    const auto [worst_supervised, median_supervised] = worst_and_median(supervised);
    fmt::print("{:<26}{}{}{}\n", name, outcome_columns(worst), outcome_columns(worst_supervised),
               first.feasible < first.trials
                   ? fmt::format("  ({} infeasible)", first.trials - first.feasible)
                   : std::string());
    if (of.size() > 1)
      fmt::print("{:<26}{}{}\n", fmt::format("  median of {}", of.size()), outcome_columns(median),
                 outcome_columns(median_supervised));
  }
  if (groups.size() < transfer.size())
    fmt::print("of several seeds the worst, and below it the median\n");
}

void print_ladder(const std::vector<LadderRow>& rung) {
  if (rung.empty()) return;
  const bool supervised = rung.front().supervised.has_value();
  fmt::print("\n{:<32}{}{} {:>10}  {}\n",
             rung.front().rung + (supervised ? "; right: supervised" : ""), kOutcomeColumns,
             supervised ? kOutcomeColumns : "", "search [s]", "worst tenth [%]");
  for (const LadderRow& r : rung)
    fmt::print(
        "{:<32}{}{} {:>10}  {}\n",
        r.training_seed ? fmt::format("{}, seed {}", r.controller, *r.training_seed) : r.controller,
        outcome_columns(r.summary), r.supervised ? outcome_columns(*r.supervised) : "",
        cell(r.search, 2),
        r.worst.name.empty()
            ? "-"
            : fmt::format("{}: {} of {:.4g} to {:.4g}", cell(100 * r.worst.rate(), 1), r.worst.name,
                          r.worst.low, r.worst.high));
  std::fflush(stdout);
}

Json to_json(const CompareArguments& a, const Scene& scene, const DemonstrationSet& set,
             std::size_t trained_starts, const Found& found) {
  const auto row = [](const auto& r) { return to_json(r); };
  return {{"scene", scene.name},
          {"demonstrations", set.demonstrations.size()},
          {"trials", a.trials},
          {"trained_starts", trained_starts},
          {"seed", a.seed},
          {"supervisor", supervisor_json(supervisor_limits(scene), scene_scaling(scene))},
          {"damage", damage_json(scene)},
          {"rows", json_list(found.entries, [&](const Entry& e) { return to_json(e, a.output); })},
          {"by_demonstrations", json_list(found.learning, learning_json)},
          {"by_seeds", json_list(found.by_seeds, by_seed_json)},
          {"transfer", json_list(found.transfer, row)},
          {"ladder", json_list(found.ladder, row)}};
}

}  // namespace ferrule
