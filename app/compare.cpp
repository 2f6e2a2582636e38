// ferrule compare: every way to insert, on the same trials.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "app/compare_plot.hpp"
#include "app/csv.hpp"
#include "app/damage.hpp"
#include "app/failures.hpp"
#include "app/given_controller.hpp"
#include "app/html.hpp"
#include "app/trained.hpp"
#include "app/verb.hpp"
#include "capture/episode.hpp"
#include "controller/campaign_table.hpp"
#include "controller/supervisor.hpp"
#include "insertion/scene_scaling.hpp"
#include "learn/candidates.hpp"
#include "learn/record_again.hpp"
#include "sim/scene/draw.hpp"

namespace ferrule {
namespace {

struct CompareArguments {
  SceneArguments scene;
  std::string folder, plot, trials_out, seeds;
  std::vector<std::string> controllers, transfer, learners;
  PolicyArguments policy;
  std::vector<std::size_t> demonstrations;
  std::size_t trials = 1000;
  double skill = 0.8;
  std::uint64_t seed = 7, fit_seed = 1;
  int threads = 0;
  bool other_scaling = false;
  Output output;
};

constexpr const char* kTeacher = "simulated operator";

// A learner with the settings that are compared.
struct ChosenLearner {
  const Learner* learner;
  const Learner::Variant* variant;
};

// A candidate and its trials, alone and under the supervisor.
struct Entry {
  Candidate candidate;
  double ns;  // per action
  std::vector<TrialResult> results, supervised_results{};
  CampaignSummary alone{}, supervised{};
  std::vector<Ring> rings{};
  std::optional<Comparison>
      against_teacher{};  // empty for the teacher, and without feasible trials
};

// Of one learner, by one seed of recording and fitting.
struct BySeed {
  std::string name;
  std::uint64_t seed;
  std::size_t demonstrations, rollouts;
  CampaignSummary summary;
};

// In another scene.
struct Transfer {
  std::string scene, controller;
  CampaignSummary alone, supervised;
};

// Everything that is found, as far as Ctrl-C lets it.
struct Found {
  std::vector<Entry> entries;
  std::vector<Learning> learning;
  std::vector<BySeed> by_seeds;
  std::vector<Transfer> transfer;
};

std::vector<TrialResult> campaign(const CompareArguments& a, const Scene& scene,
                                  const MakeController& make, const std::string& what) {
  const auto begin = std::chrono::steady_clock::now();
  std::vector<TrialResult> results =
      run_campaign(scene, scene_scaling(scene), make, a.seed, a.trials, a.threads,
                   Progress(what, a.trials), interrupted);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  fmt::print(stderr, "{}: {} trials in {:.1f} s\n", what, results.size(), took.count());
  return results;
}

std::vector<ChosenLearner> chosen_learners(const CompareArguments& a) {
  std::vector<ChosenLearner> chosen;
  for (const Learner& learner : learners())
    for (const Learner::Variant& variant : learner.variants)
      if (a.learners.empty() ||
          std::find(a.learners.begin(), a.learners.end(), variant.key) != a.learners.end())
        chosen.push_back({&learner, &variant});
  return chosen;
}

std::vector<std::string> learner_keys() {
  std::vector<std::string> keys;
  for (const ChosenLearner& c : chosen_learners({})) keys.push_back(c.variant->key);
  return keys;
}

// " and 30 labelled rollouts", or nothing.
std::string rollouts_text(std::size_t rollouts) {
  return rollouts ? fmt::format(" and {} labelled rollouts", rollouts) : std::string();
}

Candidate fitted(const CompareArguments& a, const ChosenLearner& chosen,
                 const DemonstrationSet& set) {
  Progress progress(chosen.variant->name, 1);
  Candidate c = learned(*chosen.learner, *chosen.variant, set, a.fit_seed,
                        [&](std::size_t done, std::size_t all, const std::string& note) {
                          progress(done, note, all);
                          return !interrupted();
                        });
  end_if_interrupted();
  fmt::print(stderr, "{}: fitted to {} demonstrations{} in {:.1f} s\n", c.name,
             set.demonstrations.size(), rollouts_text(c.rollouts), c.fit_seconds);
  return c;
}

std::vector<TrialResult> supervised_campaign(const CompareArguments& a, const Scene& scene,
                                             const MakeController& make, const std::string& what) {
  const SupervisorLimits limits = supervisor_limits(scene, scene_scaling(scene));
  return campaign(a, scene, supervised(make, limits), what + ", supervised");
}

Entry tried(const CompareArguments& a, const Scene& scene, const Candidate& c,
            const Demonstration& demonstration, const std::vector<Vector2d>& starts) {
  Entry e{c, ns_per_action(c, demonstration), campaign(a, scene, c.make, c.name)};
  e.alone = summarise(e.results);
  e.supervised_results = supervised_campaign(a, scene, c.make, c.name);
  e.supervised = summarise(e.supervised_results);
  e.rings = by_misalignment(e.results, starts);
  return e;
}

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

void print_alone(const std::vector<Entry>& entries) {
  fmt::print("{:<26} {:>5} {:>7} {:>9} {:>7}{} {:>9} {:>7} {:>7}\n", "", "param", "fit [s]",
             "held out", "ns", kOutcomeColumns, "loss [dB]", "to 99 %", "99.9 %");
  for (const Entry& e : entries) {
    const Candidate& c = e.candidate;
    const bool learned = c.parameters > 0;
    fmt::print("{:<26} {:>5} {:>7} {:>9} {:>7.0f}{} {:>9} {:>7} {:>7}\n", c.name,
               learned ? std::to_string(c.parameters) : "-", cell(learned ? c.fit_seconds : NAN, 2),
               cell(1e3 * c.held_out.value_or(NAN), 4), e.ns, outcome_columns(e.alone),
               cell(e.alone.loss_dB.median, 4), trials_to_show_or("-", 0.99, e.alone),
               trials_to_show_or("-", 0.999, e.alone));
  }
  fmt::print(
      "held out: velocity error on held-out demonstrations [mm/s, hand]; ns: per action;\n"
      "time and loss: medians of the inserted, peak force: median of all;\n"
      "to 99 %, 99.9 %: further trials that would show it at this rate; -: none would\n");
  for (const Entry& e : entries)
    if (const std::string note = time_limit_note(e.alone); !note.empty())
      fmt::print("{}: {}\n", e.candidate.name, note);
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
    fmt::print("{:<26}{} {:>7} {:>7} {:>7} {:>8}\n", e.candidate.name,
               outcome_columns(e.supervised), count(Intervention::held), count(Intervention::jam),
               count(Intervention::retreat),
               e.supervised.outcomes[static_cast<std::size_t>(Outcome::gave_up)]);
  }
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
    fmt::print("{:<26} {:>26} {:>9.2g} {:>23} {:>23}\n", e.candidate.name,
               fmt::format("{:+.1f} ({:+.1f} to {:+.1f})", 100 * d.difference, 100 * d.interval.low,
                           100 * d.interval.high),
               d.mcnemar_p, paired(d.time, 1), paired(d.peak_force, 1e6));
  }
  fmt::print("of the same trials, alone; time and peak force: medians of the differences\n");
  std::fflush(stdout);  // what follows takes long, and may be ended by Ctrl-C
}

Json to_json(const Entry& e, const Output& output) {
  const Candidate& c = e.candidate;
  Json row = {{"controller", c.name},
              {"parameters", c.parameters},
              {"labelled_rollouts", c.rollouts},
              {"fit_s", number_or_null(c.fit_seconds)},
              {"held_out_mm_s", number_or_null(1e3 * c.held_out.value_or(NAN))},
              {"ns_per_action", e.ns},
              {"supervised", to_json(e.supervised)}};
  row.update(to_json(e.alone));
  add_failures(e.results, output, row);
  if (c.name != kTeacher) {
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

void draw(const std::string& folder, const std::vector<Entry>& entries,
          const std::vector<Learning>& learning, const std::vector<Vector2d>& starts) {
  std::vector<std::pair<std::string, std::vector<Ring>>> rings;
  for (const Entry& e : entries) {
    rings.emplace_back(e.candidate.name, e.rings);
    std::string name = "map_";
    for (const char c : e.candidate.name)
      if (c != ',') name += c == ' ' || c == '/' ? '_' : c;
    write_svg(folder + "/" + name + ".svg", failure_map(e.candidate.name, e.results, starts));
  }
  write_svg(folder + "/misalignment.svg", misalignment_plot(rings));
  if (!learning.empty()) write_svg(folder + "/demonstrations.svg", learning_plot(learning));
}

// Which force acted when in what was learned from.
NamedHistory forces_of(const DemonstrationSet& set) {
  std::vector<InsertionForces> forces;
  for (const Demonstration& d : set.demonstrations) {
    const Episode episode = read_episode(d.file);
    forces.emplace_back(episode, recorded_scene(episode, d.file));
  }
  return {fmt::format("{} demonstrations", forces.size()), force_history(std::move(forces))};
}

// All of it in one page, on which trials that failed can be watched.
void write_report(const CompareArguments& a, const Scene& scene, const DemonstrationSet& set,
                  const Found& found, const std::vector<Vector2d>& starts,
                  const Provenance& provenance) {
  std::vector<ReplayRun> runs;
  std::vector<TrialMap> maps;
  std::vector<NamedHistory> forces{forces_of(set)};
  std::string maps_drawn, table;
  std::vector<std::pair<std::string, std::vector<Ring>>> rings;
  for (const Entry& e : found.entries) {
    const std::string& who = e.candidate.name;
    const char* against = who == "constant velocity" ? "constant-velocity"
                          : who == kTeacher          ? "operator"
                                                     : nullptr;
    const std::string command =
        against ? fmt::format("./ferrule view --trial TRIAL --against {}{} --seed {}{}", against,
                              SceneArguments{scene.name, a.scene.settings}.given(), a.seed,
                              who == kTeacher ? fmt::format(" --skill {}", a.skill) : "")
                : "";
    const TestedController tested{who, command, e.candidate.make, &e.results};
    add_failures(scene, a.seed, tested, runs, maps);
    forces.push_back(forces_of_trials(scene, a.seed, tested));
    maps_drawn += figure(failure_map(who, e.results, starts), "");
    rings.emplace_back(who, e.rings);
    table += to_text(who, e.alone);
  }
  std::string html =
      html_head("ferrule: ways to insert") + "<h1>Ways to insert, on the same trials</h1>\n" +
      replay_section("trials that failed", runs, maps) + "<pre>" + escaped(table) + "</pre>\n" +
      figure(misalignment_plot(rings), "") + to_html(forces) + maps_drawn;
  if (!found.learning.empty()) html += figure(learning_plot(found.learning), "");
  write_text(a.plot + "/report.html", html + "<p>" + escaped(provenance.head()) + "</p>\n<p>" +
                                          escaped(provenance.foot()) + "</p>\n</body></html>\n");
}

std::vector<Scene> other_scenes(const CompareArguments& a, const DemonstrationSet& set) {
  std::vector<Scene> others;
  for (const std::string& name : a.transfer) {
    others.push_back(planned_with_progress(load_scene(name)));
    refuse_other_scaling(set.scaling, a.folder, others.back(), a.other_scaling);
  }
  return others;
}

// Appends what each learner made of the demonstrations; returns those that could.
std::vector<ChosenLearner> add_learned(const CompareArguments& a, const DemonstrationSet& set,
                                       std::vector<Candidate>& candidates) {
  std::vector<ChosenLearner> could;
  for (const ChosenLearner& chosen : chosen_learners(a)) {
    const std::string& name = chosen.variant->name;
    try {
      candidates.push_back(fitted(a, chosen, set));
      could.push_back(chosen);
    } catch (const BadInput& error) {
      end_if_interrupted();
      if (!a.learners.empty()) throw BadInput(a.folder + ": " + name + ": " + error.what());
      fmt::print(stderr, "note: {} is left out: {}\n", name, error.what());
    }
  }
  return could;
}

// The controllers of files and the program that were given.
std::vector<Candidate> given(const CompareArguments& a, const Scene& scene, Provenance& provenance,
                             std::size_t& trained) {
  a.policy.periods();
  std::vector<Candidate> all;
  for (const std::string& file : a.controllers) {
    if (std::count(a.controllers.begin(), a.controllers.end(), file) > 1)
      throw BadInput("compare: " + file + " is there twice");
    const GivenController c = given_file(file, a.policy, a.seed);
    all.push_back(
        {.name = printable(c.name), .make = c.make, .fit_seconds = NAN, .periods = c.periods});
    provenance.read(file);
    if (!c.file) continue;
    const TrainedOn& training = trained_on(*c.file);
    refuse_other_scaling(training.scaling, file, scene, a.other_scaling);
    trained = std::max(trained, trained_starts(training, a.seed, a.trials));
    std::visit(
        [&](const auto& learned) {
          all.back().parameters = learned.parameters();
          all.back().held_out = learned.held_out_residual;
          all.back().rollouts = learned.trained_on.rollouts;
        },
        *c.file);
  }
  if (a.policy.command.empty()) return all;
  const GivenController c = given_program(a.policy, a.seed);
  all.push_back(
      {.name = printable(c.name), .make = c.make, .fit_seconds = NAN, .periods = c.periods});
  return all;
}

std::vector<Entry> tried_here(const CompareArguments& a, const Scene& scene,
                              const std::vector<Candidate>& candidates,
                              const Demonstration& demonstration,
                              const std::vector<Vector2d>& starts) {
  std::vector<Entry> entries;
  for (const Candidate& c : candidates) {
    if (interrupted()) break;
    entries.push_back(tried(a, scene, c, demonstration, starts));
    tell_failures(c.name, entries.back().results);
  }
  const auto teacher = std::find_if(entries.begin(), entries.end(),
                                    [](const Entry& e) { return e.candidate.name == kTeacher; });
  if (teacher == entries.end()) return entries;
  for (Entry& e : entries)
    if (e.candidate.name != kTeacher && e.alone.feasible > 0 &&
        e.results.size() == teacher->results.size())
      e.against_teacher = compare(e.results, teacher->results);
  return entries;
}

std::vector<Learning> from_fewer(const CompareArguments& a, const Scene& scene,
                                 const DemonstrationSet& set,
                                 const std::vector<ChosenLearner>& learned_by) {
  std::vector<Learning> learning;
  for (const std::size_t count : a.demonstrations) {
    if (interrupted()) break;
    if (count > set.demonstrations.size()) continue;
    for (const ChosenLearner& chosen : learned_by) {
      try {
        const Candidate c = fitted(a, chosen, first_of(set, count));
        learning.push_back(
            {c.name, count, c.rollouts, summarise(campaign(a, scene, c.make, c.name))});
      } catch (const Stopped&) {  // what is found so far is told
        return learning;
      } catch (const BadInput& error) {
        fmt::print(stderr, "note: {} is left out: {}\n", chosen.variant->name, error.what());
      }
    }
  }
  return learning;
}

// Each learner, on demonstrations that are recorded anew and fits that are drawn anew by each seed.
std::vector<BySeed> by_seeds(const CompareArguments& a, const Scene& scene,
                             const DemonstrationSet& set,
                             const std::vector<ChosenLearner>& learned_by) {
  std::vector<BySeed> all;
  if (a.seeds.empty()) return all;
  for (const std::uint64_t seed : parse_seeds(a.seeds)) {
    if (interrupted()) break;
    const DemonstrationSet again = record_again(set, seed, end_if_interrupted);
    CompareArguments with = a;
    with.fit_seed = seed;
    for (const ChosenLearner& chosen : learned_by) {
      if (interrupted()) break;
      try {
        const Candidate c = fitted(with, chosen, again);
        const auto results = campaign(a, scene, c.make, fmt::format("{}, seed {}", c.name, seed));
        if (results.size() == a.trials)
          all.push_back(
              {c.name, seed, again.demonstrations.size(), c.rollouts, summarise(results)});
      } catch (const Stopped&) {  // what is found so far is told
        return all;
      } catch (const BadInput& error) {
        end_if_interrupted();
        fmt::print(stderr, "note: seed {}: {} is left out: {}\n", seed, chosen.variant->name,
                   error.what());
      }
    }
  }
  return all;
}

// Lowest, median and highest over the seeds.
void print_by_seeds(const std::vector<BySeed>& all) {
  if (all.empty()) return;
  fmt::print("\n{:<26} {:>5} {:>31} {:>29}\n", "over seeds", "seeds",
             "inserted [%], median (range)", "time [s], median (range)");
  std::vector<std::string> names;
  for (const BySeed& each : all)
    if (std::find(names.begin(), names.end(), each.name) == names.end()) names.push_back(each.name);
  for (const std::string& name : names) {
    std::vector<double> inserted, time;
    for (const BySeed& each : all)
      if (each.name == name) {
        inserted.push_back(100 * each.summary.success_rate);
        time.push_back(each.summary.time.median);
      }
    const auto spread = [](const std::vector<double>& v, int digits) {
      return fmt::format("{} ({} to {})", cell(quantile(v, 0.5), digits),
                         cell(quantile(v, 0), digits), cell(quantile(v, 1), digits));
    };
    fmt::print("{:<26} {:>5} {:>31} {:>29}\n", name, inserted.size(), spread(inserted, 1),
               spread(time, 2));
  }
  fmt::print("each seed records the demonstrations and fits again; the trials are the same\n");
}

void print_learning(const std::vector<Learning>& learning) {
  if (learning.empty()) return;
  fmt::print("\n{:<26} {:>7}{}\n", "from fewer demonstrations", "", kOutcomeColumns);
  for (const Learning& l : learning)
    fmt::print("{:<26} {:>7}{}\n", l.name,
               l.rollouts ? fmt::format("{}+{}", l.demonstrations, l.rollouts)
                          : std::to_string(l.demonstrations),
               outcome_columns(l.summary));
  if (std::any_of(learning.begin(), learning.end(), [](const Learning& l) { return l.rollouts; }))
    fmt::print("5+30: 5 demonstrations and 30 rollouts of its own, labelled by the operator\n");
}

// What depends on the scene, as the operator does, is made for the other one.
std::vector<Transfer> tried_there(const CompareArguments& a, const Scene& other,
                                  const DemonstrationSet& set,
                                  const std::vector<Candidate>& candidates) {
  std::vector<Transfer> transfer;
  const std::vector<Candidate> there = baselines(other, set, a.skill, a.seed);
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (interrupted()) break;
    const Candidate& c = i < there.size() ? there[i] : candidates[i];
    const std::string what = other.name + ", " + c.name;
    transfer.push_back({other.name, c.name, summarise(campaign(a, other, c.make, what)),
                        summarise(supervised_campaign(a, other, c.make, what))});
  }
  return transfer;
}

// Of one scene.
void print_transfer(const std::vector<Transfer>& transfer) {
  if (transfer.empty()) return;
  fmt::print("\n{:<26}{}{}\n", fmt::format("in {}; right: supervised", transfer.front().scene),
             kOutcomeColumns, kOutcomeColumns);
  for (const Transfer& t : transfer)
    fmt::print("{:<26}{}{}{}\n", t.controller, outcome_columns(t.alone),
               outcome_columns(t.supervised),
               t.alone.feasible < t.alone.trials
                   ? fmt::format("  ({} infeasible)", t.alone.trials - t.alone.feasible)
                   : std::string());
}

Json to_json(const Learning& l) {
  Json row = {{"controller", l.name},
              {"demonstrations", l.demonstrations},
              {"labelled_rollouts", l.rollouts}};
  row.update(to_json(l.summary));
  return row;
}

Json to_json(const BySeed& s) {
  Json row = {{"controller", s.name},
              {"seed", s.seed},
              {"demonstrations", s.demonstrations},
              {"labelled_rollouts", s.rollouts}};
  row.update(to_json(s.summary));
  return row;
}

Json to_json(const Transfer& t) {
  Json row = {
      {"scene", t.scene}, {"controller", t.controller}, {"supervised", to_json(t.supervised)}};
  row.update(to_json(t.alone));
  return row;
}

// What cannot be compared is said before anything is.
void expect_comparable(const CompareArguments& a, const DemonstrationSet& set) {
  if (set.demonstrations.empty()) throw BadInput(a.folder + ": no successful demonstration");
  for (auto each = a.learners.begin(); each != a.learners.end(); ++each)
    if (std::find(a.learners.begin(), each, *each) != each)
      throw BadInput("--learners: " + *each + " is there twice");
  for (const std::size_t count : a.demonstrations)
    if (count > set.demonstrations.size())
      fmt::print(stderr, "note: {} demonstrations asked for, {} are there\n", count,
                 set.demonstrations.size());
}

std::vector<const Demonstration*> pointers(const DemonstrationSet& set) {
  std::vector<const Demonstration*> all;
  for (const Demonstration& d : set.demonstrations) all.push_back(&d);
  return all;
}

// Why it is partial, if it is.
void tell_partial(const CompareArguments& a, const std::vector<Candidate>& candidates,
                  const Found& found, Provenance& provenance) {
  if (!interrupted()) return;
  const auto whole = [&](const Entry& e) { return e.supervised_results.size() == a.trials; };
  std::string text = fmt::format("{} of {} controllers are whole",
                                 std::count_if(found.entries.begin(), found.entries.end(), whole),
                                 candidates.size());
  for (const Entry& e : found.entries)
    if (!whole(e))
      text += fmt::format("; {}: {} of {} trials alone, {} supervised", e.candidate.name,
                          e.results.size(), a.trials, e.supervised_results.size());
  if (!a.demonstrations.empty() || !a.transfer.empty() || !a.seeds.empty())
    text += "; what follows the first tables is cut";
  provenance.partial(text);
}

Json to_json(const CompareArguments& a, const Scene& scene, const DemonstrationSet& set,
             std::size_t trained_starts, const Found& found) {
  const auto row = [](const auto& r) { return to_json(r); };
  return {{"scene", scene.name},
          {"demonstrations", set.demonstrations.size()},
          {"trials", a.trials},
          {"trained_starts", trained_starts},
          {"seed", a.seed},
          {"supervisor",
           supervisor_json(supervisor_limits(scene, scene_scaling(scene)), scene_scaling(scene))},
          {"damage", damage_json(scene)},
          {"rows", json_list(found.entries, [&](const Entry& e) { return to_json(e, a.output); })},
          {"by_demonstrations", json_list(found.learning, row)},
          {"by_seeds", json_list(found.by_seeds, row)},
          {"transfer", json_list(found.transfer, row)}};
}

void write_trials(const CompareArguments& a, const Found& found, const Provenance& provenance) {
  if (a.trials_out.empty()) return;
  Json rows = Json::array();
  for (const Entry& e : found.entries) {
    add_trials(e.candidate.name, e.results, rows);
    add_trials(e.candidate.name + ", supervised", e.supervised_results, rows);
  }
  write_text(a.trials_out, csv_text(rows, provenance));
}

// What is asked for beside the first tables. Throws Stopped where Ctrl-C ends a fit.
void follow_up(const CompareArguments& a, const Scene& scene, const DemonstrationSet& set,
               const std::vector<ChosenLearner>& learned_by, const std::vector<Scene>& others,
               const std::vector<Candidate>& candidates, Found& found) {
  found.learning = from_fewer(a, scene, set, learned_by);
  if (a.output.text()) print_learning(found.learning);
  found.by_seeds = by_seeds(a, scene, set, learned_by);
  if (a.output.text()) print_by_seeds(found.by_seeds);
  for (const Scene& other : others) {
    const std::vector<Transfer> there = tried_there(a, other, set, candidates);
    if (a.output.text()) print_transfer(there);
    found.transfer.insert(found.transfer.end(), there.begin(), there.end());
  }
}

int compare_verb(const CompareArguments& a) {
  expect_place_for(a.trials_out);
  const DemonstrationSet set = load_demonstrations(a.folder, Loading());
  expect_comparable(a, set);
  const ChosenScene chosen = a.scene.choose(brought_by(set, a.folder));
  const Scene& scene = chosen.scene;
  refuse_other_scaling(set.scaling, a.folder, scene, a.other_scaling);
  const std::vector<Scene> others = other_scenes(a, set);
  if (!a.plot.empty()) make_plot_folder(a.plot);
  if (!a.seeds.empty()) {  // refused before anything is done
    parse_seeds(a.seeds);
    expect_recordable_again(set);
  }
  Provenance provenance;
  provenance.in(chosen).seed("trials", a.seed).seed("fits", a.fit_seed);
  for (const Demonstration& d : set.demonstrations) provenance.read(d.file, d.sha1);
  std::size_t seen = trained_starts(trained_on(set, pointers(set), {}, 0), a.seed, a.trials);
  const std::vector<Candidate> brought = given(a, scene, provenance, seen);
  const std::string notes = trained_starts_note(seen, a.trials) + damage_note(scene) +
                            supervisor_note(supervisor_limits(scene, scene_scaling(scene)));

  std::vector<Candidate> candidates = baselines(scene, set, a.skill, a.seed);
  const std::vector<ChosenLearner> learned_by = add_learned(a, set, candidates);
  candidates.insert(candidates.end(), brought.begin(), brought.end());
  if (a.output.text())
    fmt::print("{}{}", provenance.head(), notes);
  else
    fmt::print(stderr, "{}", notes);
  std::fflush(stdout);
  std::vector<Vector2d> starts;
  for (std::size_t k = 0; k < a.trials; ++k)
    starts.push_back(draw_start(scene, a.seed, k).tip.segment<2>(1));
  Found found;
  found.entries = tried_here(a, scene, candidates, set.demonstrations.front(), starts);
  if (a.output.text()) {
    fmt::print("{} demonstrations, {} trials each, the same for all\n\n", set.demonstrations.size(),
               a.trials);
    print_alone(found.entries);
    print_supervised(found.entries);
    print_against_teacher(found.entries);
  }
  try {
    follow_up(a, scene, set, learned_by, others, candidates, found);
  } catch (const Stopped&) {  // what is found so far is told
  }
  tell_partial(a, candidates, found, provenance);
  if (a.output.text()) fmt::print("\n{}", provenance.foot());
  print_result(a.output, to_json(a, scene, set, seen, found), "rows", provenance);
  std::fflush(stdout);  // before what may fail
  write_trials(a, found, provenance);
  if (!a.plot.empty() && !interrupted()) {
    draw(a.plot, found.entries, found.learning, starts);
    write_report(a, scene, set, found, starts, provenance);
    fmt::print(stderr, "plots are in {}, all of them in report.html\n", printable(a.plot));
  }
  if (interrupted()) return kInterrupted;
  for (const Entry& e : found.entries) refuse_if_all_failed(e.candidate.name, e.results);
  return kDone;
}

}  // namespace

void add_compare(CLI::App& app, Run& run) {
  auto* verb =
      app.add_subcommand("compare", "Ways to insert on the same trials: baselines and learned");
  auto a = std::make_shared<CompareArguments>();
  verb->add_option("folder", a->folder, "Folder with the episodes to learn from")
      ->required()
      ->type_name("DIR");
  verb->add_option("controllers", a->controllers,
                   "Controller files and TorchScript to try beside the learners")
      ->type_name("FILE.json|FILE.pt");
  a->scene.add_to(*verb, "that of the episodes");
  add_other_scaling(*verb, a->other_scaling);
  verb->add_option("--trials", a->trials, "Trials of each controller")
      ->capture_default_str()
      ->check(whole_number(1, 100000000));
  verb->add_option("--demonstrations", a->demonstrations,
                   "Learn from the first N demonstrations too, for each N")
      ->delimiter(',')
      ->type_name("N,...")
      ->check(whole_number(3, 1000000));
  verb->add_option("--transfer", a->transfer, "Try all in these scenes too, without fitting again")
      ->delimiter(',')
      ->type_name("SCENE,...");
  verb->add_option("--learners", a->learners, "Only these; all unless given")
      ->delimiter(',')
      ->check(one_of(learner_keys()));
  verb->add_option("--skill", a->skill, "Skill of the simulated operator")
      ->capture_default_str()
      ->check(number_between(0, 1));
  add_seed(*verb, a->seed, "Seed of the trials");
  add_seed(*verb, a->fit_seed, "Seed of the fits", "--fit-seed");
  add_seeds(
      *verb, a->seeds,
      "Record the simulated demonstrations and fit again with each of these seeds: the spread "
      "of the success");
  add_threads(*verb, a->threads);
  a->policy.add_to(*verb);
  verb->add_option(
          "--plot", a->plot,
          "Folder for plots: success against misalignment and number of demonstrations, maps of "
          "failures, and a report with all of them, with failed trials to watch, and which force "
          "acted when")
      ->type_name("DIR");
  verb->add_option("--trials-out", a->trials_out,
                   "Write one line per controller and trial to a file")
      ->type_name("FILE.csv");
  add_output(*verb, a->output);
  add_examples(*verb, {"compare episodes --trials 200 --learners linear,insertion",
                       "compare episodes policy.pt data/controllers/tuned_by_hand.json",
                       "compare episodes --transfer tight,sloppy --plot compared --csv"});
  verb->callback([a, &run] { run = [a] { return compare_verb(*a); }; });
}

}  // namespace ferrule
