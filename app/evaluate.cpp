// ferrule evaluate: the success rate of a controller over a campaign of trials.
#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "app/csv.hpp"
#include "app/damage.hpp"
#include "app/failures.hpp"
#include "app/given_controller.hpp"
#include "app/html.hpp"
#include "app/interrupt.hpp"
#include "app/output.hpp"
#include "app/scene_arguments.hpp"
#include "app/shards.hpp"
#include "app/stopping.hpp"
#include "app/trained.hpp"
#include "app/trial_arguments.hpp"
#include "app/validators.hpp"
#include "app/verbs.hpp"
#include "controller/campaign_table.hpp"
#include "controller/supervisor.hpp"
#include "insertion/scene_scaling.hpp"

namespace ferrule {
namespace {

struct EvaluateArguments {
  SceneArguments scene;
  std::string controller, baseline, trials_out, report;
  PolicyArguments policy;
  std::size_t trials = 1000;
  std::uint64_t seed = 7;
  int threads = 0;
  bool supervise = false, other_scaling = false;
  StoppingArguments stopping;
  Output output;
  const SharedJob* job = nullptr;
};

// A controller and what it did.
struct Tried {
  std::string name, shown_by;  // the arguments of `view` that show it; empty: none do
  MakeController make;
  Tally tally{};  // of all trials
  std::optional<Target> target{};
  std::vector<TrialResult> results{};  // of the first kKept, unless all are asked for
  WorstTenth worst{};                  // of those kKept; empty where none failed
};

// So many trials are enough to mate their connectors, to pair two controllers, and to show.
constexpr std::size_t kKept = 1 << 16;

std::string kept_note(std::size_t trials) {
  if (trials <= kKept) return "";
  return fmt::format(
      "note: the first {} trials are mated, paired, sorted into tenths and shown; all are counted, "
      "and quantiles of more than {} numbers known to 1 in {:.0f}\n",
      kKept, Quantiles::kExact, 1 / Quantiles::kWithin);
}

// Results of the trials, as far as Ctrl-C lets them go.
void run(const EvaluateArguments& a, const Scene& scene, Tried& tried) {
  const MakeController make =
      a.supervise ? supervised(tried.make, supervisor_limits(scene)) : tried.make;
  if (a.stopping.enough.target) tried.target.emplace(*a.stopping.enough.target);
  const Campaign campaign = {&scene, make, when(a.stopping.enough),
                             [&](const TrialResult& result) {
                               tried.tally.add(result);
                               if (tried.target) tried.target->after(result);
                             },
                             a.trials_out.empty() ? kKept : SIZE_MAX};
  tried.results = run_campaigns({campaign}, a.seed, a.trials, a.threads,
                                Progress(tried.name, a.trials), interrupted, a.job->store.get())
                      .front();
}

// Where each fails most; nobody who pressed Ctrl-C waits for that. Returns what chance decided in
// the trials: of all that are told one by one, or else of those of which some failed.
std::vector<DrawnQuantity> find_worst(const EvaluateArguments& a, const Scene& scene,
                                      std::vector<Tried>& all) {
  const bool in_time = !interrupted();
  const auto is_told = [&](const Tried& tried) {
    const CampaignSummary summary = tried.tally.summary();
    return in_time && summary.successes < summary.feasible;
  };
  const auto kept = [](const Tried& tried) { return std::min(tried.results.size(), kKept); };
  std::size_t most = 0;
  for (const Tried& tried : all)
    if (!a.trials_out.empty())
      most = std::max(most, tried.results.size());
    else if (is_told(tried))
      most = std::max(most, kept(tried));
  std::vector<DrawnQuantity> drawn = drawn_quantities(scene, a.seed, most);
  for (Tried& tried : all)
    if (is_told(tried))
      tried.worst = worst_tenth(drawn, std::span(tried.results).first(kept(tried)));
  return drawn;
}

// Of a controller's trials; its connectors are mated with each other.
CampaignSummary summary_of(const EvaluateArguments& a, const Scene& scene, const Tried& tried) {
  CampaignSummary summary = tried.tally.summary();
  if (tried.target) summary.target = tried.target->verdict();
  summary.mated = mated(scene, tried.results, a.seed);
  summary.worst = tried.worst;
  return summary;
}

void tell(const EvaluateArguments& a, const Scene& scene, const std::vector<Tried>& all) {
  for (const Tried& tried : all) fmt::print("{}", to_text(tried.name, summary_of(a, scene, tried)));
  if (all.size() < 2) return;
  if (const auto comparison = compare_shared(all[0].results, all[1].results))
    fmt::print("{}", to_text(*comparison));
}

Json to_json(const EvaluateArguments& a, const Scene& scene,
             std::optional<std::size_t> trained_starts, const std::vector<Tried>& all) {
  Json json = {{"scene", scene.name}, {"controller", all[0].name}, {"seed", a.seed}};
  json.update(ferrule::to_json(summary_of(a, scene, all[0])));
  if (trained_starts) json["trained_starts"] = *trained_starts;
  if (a.supervise)
    json["supervisor"] = supervisor_json(supervisor_limits(scene), scene_scaling(scene));
  json["damage"] = damage_json(scene);
  json["rows"] = json_list(all, [&](const Tried& tried) {
    Json row = {{"controller", tried.name}};
    row.update(ferrule::to_json(summary_of(a, scene, tried)));
    add_failures(tried.results, a.output, row);
    return row;
  });
  if (all.size() < 2) return json;
  json["baseline"] = json["rows"][1];
  if (const auto comparison = compare_shared(all[0].results, all[1].results))
    add_json(*comparison, json["baseline"]);
  return json;
}

// Both controllers to be tried, the first one first.
std::vector<Tried> to_try(const EvaluateArguments& a, const std::optional<GivenController>& given,
                          const Scene& scene) {
  std::vector<Tried> all;
  if (given) {
    const bool shown = a.policy.command.empty() && given->periods == 1;
    all.push_back({printable(given->name), shown ? given->name : "", given->in(scene)});
  }
  if (!a.baseline.empty())
    all.push_back({a.baseline, "--against " + a.baseline, baseline(a.baseline, scene, a.seed)});
  return all;
}

// The trials to be looked at, and the tables.
void write_report(const EvaluateArguments& a, const Scene& scene, const std::vector<Tried>& all,
                  const Provenance& provenance) {
  std::vector<ReplayRun> runs;
  std::vector<TrialMap> maps;
  std::vector<NamedHistory> forces;
  std::string text;
  for (const Tried& tried : all) {
    MakeController make = tried.make;
    if (a.supervise) make = supervised(make, supervisor_limits(scene));
    std::string command;
    if (!tried.shown_by.empty())
      command = fmt::format("./ferrule view --trial TRIAL {}{} --seed {}{}", tried.shown_by,
                            a.scene.given(), a.seed, a.supervise ? " --supervise" : "");
    const TestedController tested{tried.name, command, make, &tried.results};
    add_failures(scene, a.seed, tested, runs, maps);
    forces.push_back(forces_of_trials(scene, a.seed, tested));
    text += to_text(tried.name, summary_of(a, scene, tried));
  }
  if (runs.empty())  // nothing failed: the first trial that went in
    for (std::size_t k = 0; k < all[0].results.size() && runs.empty(); ++k)
      if (all[0].results[k].outcome == Outcome::inserted)
        runs.push_back(replay_of(scene, all[0].make, a.seed, k, fmt::format("trial {}", k)));
  if (all.size() > 1)
    if (const auto comparison = compare_shared(all[0].results, all[1].results))
      text += to_text(*comparison);
  write_text(a.report, replay_head("ferrule: trials") + "<h1>Trials of " + escaped(all[0].name) +
                           "</h1>\n" + replay_section("trials that failed", runs, maps) + "<pre>" +
                           escaped(text) + "</pre>\n" + to_html(forces) + "<p>" +
                           escaped(provenance.head()) + "</p>\n<p>" + escaped(provenance.foot()) +
                           "</p>\n</body></html>\n");
  fmt::print(stderr, "the report is {}\n", printable(a.report));
}

// What is to be tried beside the baseline.
std::optional<GivenController> given(const EvaluateArguments& a) {
  if (a.controller.empty() && a.baseline.empty() && a.policy.command.empty())
    throw BadInput(
        "evaluate: give a controller, as a file or by its name, --policy, or --baseline; or one of "
        "the first two and the last");
  if (!a.controller.empty() && !a.policy.command.empty())
    throw BadInput("evaluate: give a controller or --policy, not both");
  a.policy.periods();
  if (!a.controller.empty()) return given_controller(a.controller, a.policy, a.seed);
  if (!a.policy.command.empty()) return given_program(a.policy, a.seed);
  return std::nullopt;
}

int evaluate_verb(const EvaluateArguments& a) {
  const std::optional<GivenController> controller = given(a);
  expect_place_for(a.trials_out);
  expect_place_for(a.report);
  BroughtScene brought;
  std::optional<std::size_t> trained;
  if (controller && controller->file) {
    const TrainedOn& training = trained_on(*controller->file);
    brought = brought_by(training, a.controller);
    trained = trained_starts(training, a.seed, a.trials);
  }
  const ChosenScene chosen = a.scene.choose(brought);
  const Scene& scene = chosen.scene;
  Provenance provenance;
  provenance.in(chosen).seed("trials", a.seed);
  if (trained)
    refuse_other_scaling(trained_on(*controller->file).scaling, a.controller, scene,
                         a.other_scaling);
  if (controller && !controller->read.empty())
    provenance.read(controller->read);  // it names its weights by their hash
  const std::string notes =
      trained_starts_note(trained.value_or(0), a.trials) + damage_note(scene) +
      (a.supervise ? supervisor_note(supervisor_limits(scene)) : "") + kept_note(a.trials);
  if (a.output.text()) fmt::print("{}{}", provenance.head(), notes);
  if (!a.output.text()) fmt::print(stderr, "{}", notes);
  std::fflush(stdout);  // the trials take long

  std::vector<Tried> all = to_try(a, controller, scene);
  for (Tried& tried : all) {
    run(a, scene, tried);
    if (!interrupted()) refuse_if_all_failed(tried.name, tried.results);
  }
  const std::vector<DrawnQuantity> drawn = find_worst(a, scene, all);
  for (const Tried& tried : all) tell_failures(tried.name, tried.results);
  if (interrupted()) {
    std::string done;
    for (const Tried& tried : all)
      done += fmt::format("{}{} of {} trials of {}", done.empty() ? "" : ", ",
                          tried.tally.summary().trials, a.trials, tried.name);
    provenance.partial(done);
    while (all.size() > 1 && all.back().results.empty()) all.pop_back();
  }
  if (a.output.text()) {
    tell(a, scene, all);
    fmt::print("{}", provenance.foot());
  } else {
    print_result(a.output, to_json(a, scene, trained, all), "rows", provenance);
  }
  if (!a.trials_out.empty()) {
    Json rows = Json::array();
    for (const Tried& tried : all) add_trials(tried.name, tried.results, drawn, rows);
    write_text(a.trials_out, csv_file(rows, provenance));
  }
  if (!a.report.empty() && !interrupted()) write_report(a, scene, all, provenance);
  if (interrupted()) return kInterrupted;
  const auto& target = all[0].target;
  return target && target->verdict().kind == Verdict::refuted ? kFailed : kDone;
}

}  // namespace

void add_evaluate(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand("evaluate", "Success rate of a controller over many trials");
  auto a = std::make_shared<EvaluateArguments>();
  verb->add_option("controller", a->controller, kControllers)->type_name(kControllerType);
  a->scene.add_to(*verb, "that of the controller's training, or demo without a controller");
  add_other_scaling(*verb, a->other_scaling);
  verb->add_option("--trials", a->trials, "How many")
      ->capture_default_str()
      ->check(whole_number(1, 100000000));
  a->stopping.add_to(*verb);
  add_seed(*verb, a->seed, "Seed of the starts");
  add_threads(*verb, a->threads);
  add_shard(*verb, run.job);
  a->job = &run.job;
  verb->add_option("--baseline", a->baseline,
                   "A naive controller, or an operator who searches: alone, or on the same trials")
      ->check(one_of(baseline_names()));
  a->policy.add_to(*verb);
  verb->add_flag("--supervise", a->supervise,
                 "Put a supervisor around every controller: limits, retreat and retry");
  verb->add_option(
          "--report", a->report,
          "Write a page with a map of the trials, failed ones to watch, and which force acted when")
      ->type_name("FILE.html");
  verb->add_option("--trials-out", a->trials_out,
                   "Write one line per controller and trial to a file")
      ->type_name("FILE.csv");
  add_output(*verb, a->output);
  add_examples(*verb,
               {"evaluate controller.json --trials 200 --baseline constant-velocity",
                "evaluate controller.json --scene tight --supervise --trials-out trials.csv",
                "evaluate controller.json --target 0.999 --trials 20000",
                "evaluate --policy \"python3 examples/policy.py\" --policy-hz 50 --trials 20"});
  verb->callback([a, &run] { run.verb = [a] { return evaluate_verb(*a); }; });
}

}  // namespace ferrule
