// ferrule improve: a controller better than its teacher, by trials in the simulator.
#include "learn/improve.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "app/columns.hpp"
#include "app/shards.hpp"
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
};

// A scene to insert in, and what its trials said.
struct SceneTried {
  Scene scene;
  CampaignSummary before;
  std::optional<CampaignSummary> after{};  // empty: it was stopped
};

std::vector<SceneTried> all_scenes(const ImproveArguments& a, const Scene& chosen) {
  std::vector<SceneTried> all = {{chosen, {}}};
  for (const std::string& name : a.also)
    all.push_back({planned_with_progress(load_scene(name)), {}});
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
        c.trained_on.scene = tried.front().scene.document;
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
      return row;
    });
    for (const char* when : {"before", "after"})
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
    fmt::print(
        "after {} trials; these are others: seed {}; time: of the inserted; peak force: of all\n"
        "wrote {}\n{}",
        improved.trials, a.seed, a.out, provenance.foot());
  }
}

CampaignSummary in_unseen_trials(const ImproveArguments& a, const ControllerFile& controller,
                                 const Scene& scene) {
  return summarise(run_campaign(scene, maker(controller), a.seed, a.unseen, a.settings.threads, {},
                                interrupted, {}, a.settings.shared));
}

// How the controller inserts before, and what its trials cost in units of that.
std::vector<ImproveTask> measure_before(const ImproveArguments& a, const ControllerFile& before,
                                        std::vector<SceneTried>& tried) {
  const auto counts = [&a](const char* what) {
    return std::find(a.objective.begin(), a.objective.end(), what) != a.objective.end();
  };
  std::vector<ImproveTask> tasks;
  for (SceneTried& each : tried) {
    each.before = in_unseen_trials(a, before, each.scene);
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
  a.settings.shared = shared_trials();
  if (!runs_a_shard()) expect_place_for(a.out);
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
  if (!runs_a_shard()) write_controller(a.out, after);
  for (SceneTried& each : tried) {
    const CampaignSummary summary = in_unseen_trials(a, after, each.scene);
    if (interrupted()) break;
    each.after = summary;
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
  add_shard(*verb, true);
  add_json(*verb, a->json);
  add_examples(*verb, {"improve tuned_by_hand --scene bench --out improved.json",
                       "improve search --scene ladder/d --objective success,time --trials 30000 "
                       "--out improved.json --json",
                       "improve tuned_by_hand --scene bench --also sticky,tight --trials 30000 "
                       "--out improved.json"});
  verb->callback([a, &run] { run = [a] { return improve_verb(*a); }; });
}

}  // namespace ferrule
