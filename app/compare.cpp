// ferrule compare: every way to insert, on the same trials.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "app/compare_plot.hpp"
#include "app/compared_ladder.hpp"
#include "app/compared_learners.hpp"
#include "app/csv.hpp"
#include "app/damage.hpp"
#include "app/interrupt.hpp"
#include "app/output.hpp"
#include "app/scene_arguments.hpp"
#include "app/shards.hpp"
#include "app/trained.hpp"
#include "app/trial_arguments.hpp"
#include "app/validators.hpp"
#include "app/verbs.hpp"
#include "controller/campaign_table.hpp"
#include "controller/supervisor.hpp"
#include "insertion/scene_scaling.hpp"
#include "learn/record_again.hpp"
#include "sim/scene/draw.hpp"

namespace ferrule {
namespace {

std::vector<TrialResult> campaign(const CompareArguments& a, const Scene& scene,
                                  const MakeController& make, const std::string& what) {
  const auto begin = std::chrono::steady_clock::now();
  std::vector<TrialResult> results =
      run_campaign(scene, make, a.seed, a.trials, a.threads, Progress(what, a.trials), interrupted,
                   when(a.stopping.enough), a.job->store.get());
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  fmt::print(stderr, "{}: {} trials in {:.1f} s\n", what, results.size(), took.count());
  return results;
}

std::vector<TrialResult> supervised_campaign(const CompareArguments& a, const Scene& scene,
                                             const MakeController& make, const std::string& what) {
  const SupervisorLimits limits = supervisor_limits(scene);
  return campaign(a, scene, supervised(make, limits), what + ", supervised");
}

Entry tried(const CompareArguments& a, const Scene& scene, const Compared& c,
            const Demonstration& demonstration) {
  Entry e{c, ns_per_action(c, demonstration), campaign(a, scene, c.make, c.name)};
  e.alone = a.stopping.summary(e.results);
  e.supervised_results = supervised_campaign(a, scene, c.make, c.name);
  e.supervised = a.stopping.summary(e.supervised_results);
  return e;
}

std::vector<Scene> other_scenes(const CompareArguments& a, const DemonstrationSet& set,
                                const std::vector<std::string>& names) {
  std::vector<Scene> others;
  for (const std::string& name : names) {
    others.push_back(planned_with_progress(load_scene(name)));
    refuse_other_scaling(set.scaling, a.folder, others.back(), a.other_scaling);
  }
  return others;
}

// The controllers of files and the program that were given.
std::vector<Compared> given(const CompareArguments& a, const Scene& scene, Provenance& provenance,
                            std::size_t& trained) {
  a.policy.periods();
  std::vector<Compared> all;
  for (const std::string& file : a.controllers) {
    if (std::count(a.controllers.begin(), a.controllers.end(), file) > 1)
      throw BadInput("compare: " + file + " is there twice");
    if (is_baseline(file)) continue;  // without_learning has it
    const GivenController c = given_controller(file, a.policy, a.seed);
    all.push_back({{.name = printable(c.name),
                    .make = c.in(scene),
                    .fit_seconds = NAN,
                    .periods = c.periods}});
    provenance.read(c.read);
    if (!c.file) continue;
    const TrainedOn& training = trained_on(*c.file);
    refuse_other_scaling(training.scaling, file, scene, a.other_scaling);
    trained = std::max(trained, trained_starts(training, a.seed, a.trials));
    all.back().file = c.file;
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
      {{.name = printable(c.name), .make = c.in(scene), .fit_seconds = NAN, .periods = c.periods}});
  return all;
}

// Null: he is not there.
const std::vector<TrialResult>* results_of_teacher(const std::vector<Entry>& entries) {
  const auto teacher = std::find_if(entries.begin(), entries.end(),
                                    [](const Entry& e) { return e.name == kTeacher; });
  return teacher == entries.end() ? nullptr : &teacher->results;
}

std::vector<Entry> tried_here(const CompareArguments& a, const Scene& scene,
                              const std::vector<Compared>& all,
                              const Demonstration& demonstration) {
  std::vector<Entry> entries;
  for (const Compared& c : all) {
    if (interrupted()) break;
    entries.push_back(tried(a, scene, c, demonstration));
    tell_failures(c.name, entries.back().results);
  }
  if (const std::vector<TrialResult>* teacher = results_of_teacher(entries))
    for (Entry& e : entries)
      if (e.name != kTeacher) e.against_teacher = compare_shared(e.results, *teacher);
  return entries;
}

// Where the trials that were made started, across the bore [m].
std::vector<Vector2d> starts_of(const Scene& scene, std::uint64_t seed,
                                const std::vector<Entry>& entries) {
  std::size_t trials = 0;
  for (const Entry& e : entries) trials = std::max(trials, e.results.size());
  std::vector<Vector2d> starts;
  for (std::size_t k = 0; k < trials; ++k)
    starts.push_back(draw_start(scene, seed, k).tip.segment<2>(1));
  return starts;
}

// What the learners make of the first of the demonstrations, which the seed a.fit_seed recorded.
void learn_from_fewer(const CompareArguments& a, const Scene& scene, const DemonstrationSet& set,
                      const std::vector<Entry>& entries, std::vector<LearnedAgain>& learning) {
  for (const std::size_t count : a.demonstrations) {
    if (count > set.demonstrations.size()) continue;
    for (const Entry& e : entries) {
      if (!e.fit) continue;
      end_if_interrupted();
      try {
        const Compared c =
            fitted(a, e.fit->by, first_of(set, count), fmt::format("first {}", count));
        learning.push_back({c, a.stopping.summary(campaign(a, scene, c.make, c.name))});
      } catch (const BadInput& error) {
        fmt::print(stderr, "note: {} is left out: {}\n", e.name, error.what());
      }
    }
  }
}

// The learners on demonstrations that a.fit_seed recorded again.
std::vector<LearnedAgain> learned_again(const CompareArguments& a, const Scene& scene,
                                        const DemonstrationSet& set,
                                        const std::vector<Entry>& entries) {
  const std::vector<TrialResult>* teacher = results_of_teacher(entries);
  std::vector<LearnedAgain> all;
  for (const Entry& e : entries) {
    if (!e.fit) continue;
    end_if_interrupted();
    try {
      const Compared c = fitted(a, e.fit->by, set, "recorded again");
      const auto results =
          campaign(a, scene, c.make, fmt::format("{}, seed {}", c.name, a.fit_seed));
      if (a.job->runs_a_shard() || a.stopping.whole(results, a.trials))
        all.push_back({c, a.stopping.summary(results),
                       teacher ? compare_shared(results, *teacher) : std::nullopt});
    } catch (const BadInput& error) {
      end_if_interrupted();
      fmt::print(stderr, "note: seed {}: {} is left out: {}\n", a.fit_seed, e.name, error.what());
    }
  }
  return all;
}

// What depends on the scene, as the operator does, is made for the other one.
std::vector<Transfer> tried_there(const CompareArguments& a, const Scene& other,
                                  const DemonstrationSet& set,
                                  const std::vector<Compared>& learned) {
  std::vector<Compared> all = without_learning(a, other, set);
  all.insert(all.end(), learned.begin(), learned.end());
  std::vector<Transfer> transfer;
  for (const Compared& c : all) {
    if (interrupted()) break;
    const std::string what = other.name + ", " + c.name;
    transfer.push_back({other.name, c.name, training_seed(c),
                        a.stopping.summary(campaign(a, other, c.make, what)),
                        a.stopping.summary(supervised_campaign(a, other, c.make, what))});
  }
  return transfer;
}

// What cannot be compared is said before anything is.
void expect_comparable(const CompareArguments& a, const DemonstrationSet& set) {
  if (set.demonstrations.empty()) throw BadInput(a.folder + ": no successful demonstration");
  for (const auto& [flag, list] : {std::pair("--learners", &a.learners), {"--ablate", &a.ablate}})
    for (auto each = list->begin(); each != list->end(); ++each)
      if (std::find(list->begin(), each, *each) != each)
        throw BadInput(std::string(flag) + ": " + *each + " is there twice");
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

// Of each controller alone.
bool all_refuted(const std::vector<Entry>& entries) {
  return !entries.empty() && std::all_of(entries.begin(), entries.end(), [](const Entry& e) {
    return e.alone.target && e.alone.target->kind == Verdict::refuted;
  });
}

// Why it is partial, if it is.
void tell_partial(const CompareArguments& a, std::size_t controllers, const Found& found,
                  Provenance& provenance) {
  if (!interrupted()) return;
  const auto whole = [&](const Entry& e) {
    return a.stopping.whole(e.supervised_results, a.trials);
  };
  std::string text =
      fmt::format("{} of {} controllers are whole",
                  std::count_if(found.entries.begin(), found.entries.end(), whole), controllers);
  for (const Entry& e : found.entries)
    if (!whole(e))
      text += fmt::format("; {}: {} of {} trials alone, {} supervised", e.name, e.results.size(),
                          a.trials, e.supervised_results.size());
  if (!a.demonstrations.empty() || !a.transfer.empty() || !a.seeds.empty() || a.ladder)
    text += "; what follows the first tables is cut";
  provenance.partial(text);
}

void write_trials(const CompareArguments& a, const Scene& scene, const Found& found,
                  const Provenance& provenance) {
  if (a.trials_out.empty()) return;
  std::size_t trials = 0;  // of whoever needed most
  for (const Entry& e : found.entries)
    trials = std::max({trials, e.results.size(), e.supervised_results.size()});
  const std::vector<DrawnQuantity> drawn = drawn_quantities(scene, a.seed, trials);
  Json rows = Json::array();
  for (const Entry& e : found.entries) {
    add_trials(e.name, e.results, drawn, rows);
    add_trials(e.name + ", supervised", e.supervised_results, drawn, rows);
  }
  write_text(a.trials_out, csv_file(rows, provenance));
}

// Fills in what is learned from fewer demonstrations and, with --seeds, from each recording anew;
// returns what --ablate leaves of them, and of what was given. Throws Stopped at Ctrl-C.
std::vector<Compared> learn_again(const CompareArguments& a, const Scene& scene,
                                  const DemonstrationSet& set, Found& found) {
  std::vector<Compared> less;
  const auto add_ablated = [&](const CompareArguments& with, const DemonstrationSet& from,
                               const Compared& whole) {
    for (Compared& c : ablated(with, from, whole)) less.push_back(std::move(c));
  };
  if (a.seeds.empty()) {
    learn_from_fewer(a, scene, set, found.entries, found.learning);
  } else {
    for (const std::uint64_t seed : parse_seeds(a.seeds)) {
      const DemonstrationSet again = record_again(set, seed, end_if_interrupted);
      CompareArguments with = a;
      with.fit_seed = seed;
      learn_from_fewer(with, scene, again, found.entries, found.learning);
      for (const LearnedAgain& each : learned_again(with, scene, again, found.entries)) {
        add_ablated(with, again, each);
        found.by_seeds.push_back(each);
      }
    }
  }
  for (const Entry& e : found.entries)
    if (!e.of_scene && (!e.fit || a.seeds.empty())) add_ablated(a, set, e);
  return less;
}

// What is asked for beside the first tables. Throws Stopped where Ctrl-C ends a fit.
void follow_up(const CompareArguments& a, const Scene& scene, const DemonstrationSet& set,
               const std::vector<Scene>& others, const std::vector<Scene>& ladder, Found& found) {
  std::vector<Compared> less;
  try {
    less = learn_again(a, scene, set, found);
  } catch (const Stopped&) {  // what is found so far is told
  }
  if (a.output.text()) print_learning(found.learning);
  if (a.output.text()) print_by_seeds(found.by_seeds);
  std::vector<Compared> rest = for_all_scenes(found.entries, found.by_seeds);
  for (const Scene& other : others) {
    if (interrupted()) break;
    const std::vector<Transfer> there = tried_there(a, other, set, rest);
    if (a.output.text()) print_transfer(there);
    found.transfer.insert(found.transfer.end(), there.begin(), there.end());
  }
  rest.insert(rest.end(), less.begin(), less.end());
  for (const Scene& rung : ladder) {
    if (interrupted()) break;
    const std::vector<LadderRow> rows = climb(a, rung, set, rest);
    if (a.output.text()) print_ladder(rows);
    found.ladder.insert(found.ladder.end(), rows.begin(), rows.end());
  }
}

// What was found in the scene of the demonstrations.
void print_here(const CompareArguments& a, const DemonstrationSet& set,
                const std::vector<Entry>& entries) {
  fmt::print("{} demonstrations, {}{} trials each, the same for all\n\n", set.demonstrations.size(),
             when(a.stopping.enough) ? "at most " : "", a.trials);
  print_alone(entries);
  print_supervised(entries);
  print_targets(entries);
  print_against_teacher(entries);
}

int compare_verb(const CompareArguments& a) {
  expect_place_for(a.trials_out);
  const DemonstrationSet set = load_demonstrations(a.folder, Loading());
  for (const EpisodeCopy& copy : set.copies)
    fmt::print(stderr, "note: {}\n", printable(copy.text()));
  expect_comparable(a, set);
  const ChosenScene chosen = a.scene.choose(brought_by(set, a.folder));
  const Scene& scene = chosen.scene;
  refuse_other_scaling(set.scaling, a.folder, scene, a.other_scaling);
  const std::vector<Scene> others = other_scenes(a, set, a.transfer);
  const std::vector<Scene> ladder =
      other_scenes(a, set, a.ladder ? rungs() : std::vector<std::string>());
  if (!a.plot.empty()) make_plot_folder(a.plot);
  // Refused before anything is done.
  if (!a.seeds.empty()) parse_seeds(a.seeds);
  if (!a.seeds.empty() || asks_for(a, Ablation::variation)) expect_recordable_again(set);
  Provenance provenance;
  provenance.in(chosen).seed("trials", a.seed).seed("fits", a.fit_seed);
  for (const Demonstration& d : set.demonstrations) provenance.read(d.file, d.sha1);
  std::size_t seen = trained_starts(trained_on(set, pointers(set), {}, 0), a.seed, a.trials);
  const std::vector<Compared> brought = given(a, scene, provenance, seen);
  const std::string notes = trained_starts_note(seen, a.trials) + damage_note(scene) +
                            supervisor_note(supervisor_limits(scene));

  std::vector<Compared> all = without_learning(a, scene, set);
  const std::vector<Compared> learned = fitted_by_all(a, set);
  all.insert(all.end(), learned.begin(), learned.end());
  all.insert(all.end(), brought.begin(), brought.end());
  if (a.output.text())
    fmt::print("{}{}", provenance.head(), notes);
  else
    fmt::print(stderr, "{}", notes);
  std::fflush(stdout);
  Found found;
  found.entries = tried_here(a, scene, all, set.demonstrations.front());
  const std::vector<Vector2d> starts = starts_of(scene, a.seed, found.entries);
  for (Entry& e : found.entries) e.rings = by_misalignment(e.results, starts);
  if (a.output.text()) print_here(a, set, found.entries);
  try {
    follow_up(a, scene, set, others, ladder, found);
  } catch (const Stopped&) {  // what is found so far is told
  }
  tell_partial(a, all.size(), found, provenance);
  if (a.output.text()) fmt::print("\n{}", provenance.foot());
  print_result(a.output, to_json(a, scene, set, seen, found), "rows", provenance);
  std::fflush(stdout);  // before what may fail
  write_trials(a, scene, found, provenance);
  if (!a.plot.empty() && !interrupted()) {
    write_plots(a, scene, set, found, starts, provenance);
    fmt::print(stderr, "plots are in {}, all of them in report.html\n", printable(a.plot));
  }
  if (interrupted()) return kInterrupted;
  for (const Entry& e : found.entries) refuse_if_all_failed(e.name, e.results);
  return all_refuted(found.entries) ? kFailed : kDone;
}

void add_ladder(CLI::App& verb, CompareArguments& a) {
  verb.add_flag("--ladder", a.ladder,
                "Try all, and a blind spiral, on every rung of the ladder too (docs/results.md)");
  verb.add_flag("--supervise", a.supervise, "Try all there under the supervisor, too")
      ->needs("--ladder");
  verb.add_option("--ablate", a.ablate,
                  "Try what learns and what is given there without this, too: what it feels, "
                  "where it has moved, rates of tilt, variation in what it learns from")
      ->needs("--ladder")
      ->delimiter(',')
      ->check(one_of({kAblations.begin(), kAblations.end()}))
      ->type_name("force,memory,tilt,variation");
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
                   "To try beside the learners. " + std::string(kControllers))
      ->type_name(kControllerType);
  a->scene.add_to(*verb, "that of the episodes");
  add_other_scaling(*verb, a->other_scaling);
  verb->add_option("--trials", a->trials, "Trials of each controller")
      ->capture_default_str()
      ->check(whole_number(1, 100000000));
  a->stopping.add_to(*verb);
  verb->add_option("--demonstrations", a->demonstrations,
                   "Learn from the first N demonstrations too, for each N")
      ->delimiter(',')
      ->type_name("N,...")
      ->check(whole_number(3, 1000000));
  verb->add_option("--transfer", a->transfer, "Try all in these scenes too, without fitting again")
      ->delimiter(',')
      ->type_name("SCENE,...");
  add_ladder(*verb, *a);
  verb->add_option("--learners", a->learners, "Only these; all unless given")
      ->delimiter(',')
      ->check(one_of(learner_keys()));
  add_skill(*verb, a->skill, "Skill of the simulated operator");
  add_seed(*verb, a->seed, "Seed of the trials");
  add_seed(*verb, a->fit_seed, "Seed of the fits", "--fit-seed");
  add_seeds(
      *verb, a->seeds,
      "Record the simulated demonstrations and fit again with each of these seeds, also for what "
      "follows here: the worst and the median of the success");
  add_threads(*verb, a->threads);
  add_shard(*verb, run.job);
  a->job = &run.job;
  a->policy.add_to(*verb);
  verb->add_option(
          "--plot", a->plot,
          "Folder for plots: success against misalignment, number of demonstrations and what "
          "decides on each rung, maps of failures, and a report with all of them, with failed "
          "trials to watch, and which force acted when")
      ->type_name("DIR");
  verb->add_option("--trials-out", a->trials_out,
                   "Write one line per controller and trial to a file")
      ->type_name("FILE.csv");
  add_output(*verb, a->output);
  add_examples(*verb, {"compare episodes --trials 200 --learners linear,insertion",
                       "compare episodes policy.pt data/controllers/tuned_by_hand.json",
                       "compare episodes search --ladder --learners insertion --seeds 1..5",
                       "compare episodes search --ladder --learners torch --ablate force,tilt",
                       "compare episodes --transfer tight,sloppy --plot compared --csv"});
  verb->callback([a, &run] { run.verb = [a] { return compare_verb(*a); }; });
}

}  // namespace ferrule
