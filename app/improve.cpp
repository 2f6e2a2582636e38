// ferrule improve: a controller better than its teacher, by trials in the simulator.
#include "learn/improve.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "app/columns.hpp"
#include "app/shards.hpp"
#include "app/trial_arguments.hpp"
#include "app/validators.hpp"
#include "app/varied_scene.hpp"
#include "controller/campaign_table.hpp"

namespace ferrule {
namespace {

struct ImproveArguments {
  SceneArguments scene;
  std::vector<std::string> also;
  std::string controller, out;
  std::vector<std::string> objective = {"success", "time", "force"};
  ImproveSettings settings;
  std::size_t unseen = 1000;
  std::uint64_t seed = 7;
  bool other_scaling = false, json = false;
  const SharedJob* job = nullptr;
};

// A scene to insert in, and what its trials said.
struct SceneTried {
  Scene scene;
  CampaignSummary before;
  std::vector<TrialResult> trials_before;
  std::optional<CampaignSummary> after{};  // empty: it was stopped
  std::optional<Comparison> change{};      // after minus before, in the same trials
};

std::vector<SceneTried> all_scenes(const ImproveArguments& a, const Scene& chosen) {
  std::vector<SceneTried> all = {{chosen, {}, {}}};
  for (const std::string& name : a.also)
    all.push_back({planned_with_progress(load_scene(name)), {}, {}});
  return all;
}

// Changed gains have no intervals, and no error against demonstrations.
ControllerFile as_improved(const ControllerFile& controller, const std::vector<SceneTried>& tried,
                           const Improved& improved) {
  ControllerFile file = improved.controller;
  std::vector<std::string> scenes;
  for (const SceneTried& each : tried) scenes.push_back(each.scene.name);
  std::visit(
      [&](auto& c) {
        c.trained_on.scenes = scenes;
        c.trained_on.scene = tried.front().scene.document();
        c.trained_on.rollouts += improved.trials;
        c.trained_on.partial = interrupted();
      },
      file);
  if (auto* law = std::get_if<LawFile>(&file)) law->held_out_residual = NAN;
  if (auto* search = std::get_if<SearchFile>(&file))
    for (const std::size_t i : free_gains(controller))
      search->sources[i] = fmt::format("improved from {} in {} by {} trials", gain(controller, i),
                                       fmt::join(scenes, ", "), improved.trials);
  return file;
}

struct Told {
  std::string scene;
  const char* when;
  CampaignSummary summary;
};

Columns<Told> columns() {
  Columns<Told> table = {{"", "scene", "<16", [](const Told& t) { return Json(t.scene); }},
                         {"", "controller", "<10", [](const Told& t) { return Json(t.when); }}};
  const auto add = [&](const char* heading, const char* format, auto cell) {
    table.push_back({"", heading, format, [cell](const Told& t) { return cell(t.summary); }});
  };
  using S = const CampaignSummary&;
  add_success_columns(add);
  add("time [s]", ">9.2f", [](S s) { return Json(s.time.median); });
  add("95 %", ">7.2f", [](S s) { return Json(s.time.p95); });
  add("peak [uN]", ">9.2f", [](S s) { return Json(1e6 * s.peak_force.median); });
  add("95 %", ">7.2f", [](S s) { return Json(1e6 * s.peak_force.p95); });
  return table;
}

void tell(const ControllerFile& before, const ControllerFile& after) {
  fmt::print("{:>20} {:>14} {:>14}\n", "gain", "before", "after");
  for (const std::size_t i : free_gains(before))
    fmt::print("{:>20} {:>14.4g} {:>14.4g}\n", gain_name(before, i), gain(before, i),
               gain(after, i));
}

// Does a 95 % interval say of which sign it is?
bool shows(const Interval& interval) {
  return interval.low > 0 || interval.high < 0;
}

// A change of which the trials say the sign or do not, and its text.
struct Change {
  bool shown;
  std::string text;
};

std::vector<Change> changes_of(const Comparison& c) {
  const auto change = [](const char* what, const char* unit, int digits, double scale, double value,
                         const Interval& in) {
    if (!std::isfinite(in.low)) return Change{false, fmt::format("{} (too few trials)", what)};
    return Change{shows(in),
                  fmt::format("{} {:+.{}f} {} (95 %: {:+.{}f} to {:+.{}f})", what, scale * value,
                              digits, unit, scale * in.low, digits, scale * in.high, digits)};
  };
  return {change("inserted", "points", 1, 100, c.difference, c.interval),
          change("time", "s", 2, 1, c.time.median, c.time.interval),
          change("peak force", "uN", 2, 1e6, c.peak_force.median, c.peak_force.interval)};
}

Json to_json(const Comparison& c) {
  Json json;
  add_json(c, json);
  json["told_apart"] = {{"success", shows(c.interval)},
                        {"time", shows(c.time.interval)},
                        {"peak_force", shows(c.peak_force.interval)}};
  return json;
}

// "after minus before: time -9.2 s (...); not told apart: inserted ..."
std::string change_in_words(const Comparison& change) {
  std::string shown, open;
  for (const Change& each : changes_of(change)) {
    std::string& text = each.shown ? shown : open;
    text += (text.empty() ? "" : ", ") + each.text;
  }
  if (shown.empty()) return "these trials do not tell it from before: " + open;
  return "after minus before: " + shown + (open.empty() ? "" : "; not told apart: " + open);
}

const ImproveCentre* runner_up(const Improved& improved) {
  const ImproveCentre* least = nullptr;
  for (const ImproveCentre& centre : improved.choice)
    if (!centre.chosen && (!least || centre.objective < least->objective)) least = &centre;
  return least;
}

// What it was chosen from, and whether the trials that chose it tell it from the others.
std::string choice_in_words(const Improved& improved) {
  const ImproveCentre* next = runner_up(improved);
  if (!next) return "";
  const auto alike =
      std::count_if(improved.choice.begin(), improved.choice.end(),
                    [](const ImproveCentre& c) { return !c.chosen && !(c.above_chosen.low > 0); });
  return fmt::format(
      "{}chosen of {} by {} trials each in each scene, which {}: the objective of the next, {}, is "
      "{:.3g} to {:.3g} more (95 %)\n",
      improved.choice.front().chosen ? "nothing better was found, the gains are as before; " : "",
      improved.choice.size(), ImproveCentre::kTrials,
      alike > 0 ? fmt::format("do not tell it from {} of the others", alike)
                : "tell it from all others",
      next->before ? "the controller before" : "a centre of the search", next->above_chosen.low,
      next->above_chosen.high);
}

void show(const ImproveArguments& a, const ControllerFile& before, const ControllerFile& after,
          const Improved& improved, const std::vector<SceneTried>& tried,
          const Provenance& provenance) {
  if (a.json) {
    Json json = {{"controller", printable(a.controller)},
                 {"out", a.out},
                 {"objective", a.objective},
                 {"trials", improved.trials},
                 {"rows", json_list(improved.rows, [](const ImproveRow& row) {
                    return Json{{"trials", row.trials},
                                {"objective", number_or_null(row.objective)},
                                {"spread", row.spread}};
                  })}};
    json["scenes"] = json_list(tried, [](const SceneTried& each) {
      Json row = {{"scene", each.scene.name}, {"before", short_row(to_json(each.before))}};
      if (each.after) row["after"] = short_row(to_json(*each.after));
      if (each.change) row["change"] = to_json(*each.change);
      return row;
    });
    json["choice"] = json_list(improved.choice, [](const ImproveCentre& c) {
      return Json{{"before", c.before},
                  {"chosen", c.chosen},
                  {"objective", number_or_null(c.objective)},
                  {"more_low", number_or_null(c.above_chosen.low)},
                  {"more_high", number_or_null(c.above_chosen.high)},
                  {"told_apart", c.above_chosen.low > 0}};
    });
    for (const char* when : {"before", "after", "change"})
      if (const auto& first = json["scenes"][0]; first.contains(when)) json[when] = first[when];
    print_json(std::move(json), provenance);
  } else {
    tell(before, after);
    std::vector<Told> told;
    for (const SceneTried& each : tried) {
      told.push_back({printable(each.scene.name), "before", each.before});
      if (each.after) told.push_back({"", "after", *each.after});
    }
    print_table(columns(), told);
    for (const SceneTried& each : tried)
      if (each.change)
        fmt::print("{}: {}\n", printable(each.scene.name), change_in_words(*each.change));
    fmt::print("{}", choice_in_words(improved));
    fmt::print(
        "after {} trials; these are others: seed {}; time: of the inserted; peak force: of all\n"
        "wrote {}\n{}",
        improved.trials, a.seed, a.out, provenance.foot());
  }
}

std::vector<TrialResult> in_unseen_trials(const ImproveArguments& a,
                                          const ControllerFile& controller, const Scene& scene) {
  return run_campaign(scene, maker(controller), a.seed, a.unseen, a.settings.threads, {},
                      interrupted, {}, a.settings.kept);
}

// How the controller inserts before, and what its trials cost in units of that.
std::vector<ImproveTask> measure_before(const ImproveArguments& a, const ControllerFile& before,
                                        std::vector<SceneTried>& tried) {
  const auto counts = [&a](const char* what) {
    return std::find(a.objective.begin(), a.objective.end(), what) != a.objective.end();
  };
  std::vector<ImproveTask> tasks;
  for (SceneTried& each : tried) {
    each.trials_before = in_unseen_trials(a, before, each.scene);
    each.before = summarise(each.trials_before);
    end_if_interrupted();
    Objective objective;
    if (counts("time")) objective.time = each.before.time.median;
    if (counts("force")) objective.force = each.before.peak_force.median;
    tasks.push_back({&each.scene, objective});
  }
  return tasks;
}

void refuse_too_few(const ImproveSettings& settings, std::size_t least) {
  if (settings.trials < least)
    throw BadInput(fmt::format(
        "--trials = {}: must be at least {} for one generation and the choice in the end",
        settings.trials, least));
}

int improve_verb(ImproveArguments a) {
  a.settings.kept = a.job->store.get();
  if (!a.job->runs_a_shard()) expect_place_for(a.out);
  const ControllerFile before =
      own_controller(a.controller, "has no gains to improve; give a law or a search");
  const BroughtScene brought = brought_by(trained_on(before), a.controller);
  const ChosenScene chosen = a.scene.choose(brought);
  std::vector<SceneTried> tried = all_scenes(a, chosen.scene);
  for (const SceneTried& each : tried)
    refuse_other_scaling(trained_on(before).scaling, a.controller, each.scene, a.other_scaling);
  refuse_too_few(a.settings, least_trials(before, tried.size(), a.settings));
  Provenance provenance;
  provenance.in(chosen).seed("search", a.settings.seed).seed("unseen trials", a.seed);
  provenance.read(controller_file(a.controller));
  if (!a.json) fmt::print("{}", provenance.head());
  std::fflush(stdout);  // the trials take long

  const std::vector<ImproveTask> tasks = measure_before(a, before, tried);

  Improved improved;
  {
    Progress bar("trials", a.settings.trials);
    improved = improve(
        before, tasks, a.settings,
        [&](const ImproveRow& row) { bar(row.trials, fmt::format("{:.3g}", row.objective)); },
        interrupted);
  }
  if (interrupted()) provenance.partial(fmt::format("{} trials", improved.trials));
  const ControllerFile after = as_improved(before, tried, improved);
  if (!a.job->runs_a_shard()) write_controller(a.out, after);
  for (SceneTried& each : tried) {
    const std::vector<TrialResult> trials = in_unseen_trials(a, after, each.scene);
    if (interrupted()) break;
    each.after = summarise(trials);
    each.change = compare_shared(trials, each.trials_before);
  }
  show(a, before, after, improved, tried, provenance);
  return interrupted() ? kInterrupted : kDone;
}

}  // namespace

void add_improve(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand(
      "improve", "Change the gains of a controller until it inserts better and sooner");
  auto a = std::make_shared<ImproveArguments>();
  verb->add_option("controller", a->controller, "Controller: a file, or a shipped one")
      ->type_name("FILE.json")
      ->required();
  verb->add_option("--out", a->out, "The better one")->type_name("FILE.json")->required();
  a->scene.add_to(*verb, "that of the controller's training, or demo");
  verb->add_option("--also", a->also, "Other scenes to insert in, each counts as much")
      ->delimiter(',')
      ->type_name("SCENE,...");
  add_other_scaling(*verb, a->other_scaling);
  verb->add_option("--objective", a->objective,
                   "What counts: a failure as ten insertions; time and peak force in units of "
                   "what they were")
      ->delimiter(',')
      ->check(one_of({"success", "time", "force"}))
      ->type_name("success,time,force");
  verb->add_option("--trials", a->settings.trials, "Trials in all, at most")
      ->capture_default_str()
      ->check(whole_number(1000, 100000000));
  verb->add_option("--trials-each", a->settings.trials_each,
                   "Trials of a candidate in each scene, the same for all of a generation")
      ->capture_default_str()
      ->check(whole_number(1, 100000));
  add_seed(*verb, a->settings.seed, "Seed of the search", "--search-seed");
  verb->add_option("--unseen", a->unseen,
                   "Trials of before and after, which the search has not seen")
      ->capture_default_str()
      ->check(whole_number(1, 100000000));
  add_seed(*verb, a->seed, "Seed of those");
  add_threads(*verb, a->settings.threads);
  add_shard(*verb, run.job, true);
  a->job = &run.job;
  add_json(*verb, a->json);
  add_examples(*verb, {"improve tuned_by_hand --scene bench --out improved.json",
                       "improve search --scene ladder/d --objective success,time --trials 30000 "
                       "--out improved.json --json",
                       "improve tuned_by_hand --scene bench --also sticky,tight --trials 30000 "
                       "--out improved.json"});
  verb->callback([a, &run] { run.verb = [a] { return improve_verb(*a); }; });
}

}  // namespace ferrule
