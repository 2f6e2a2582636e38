#include "app/varied_scene.hpp"

#include <fmt/format.h>

#include "app/damage.hpp"
#include "app/shards.hpp"
#include "app/trial_arguments.hpp"
#include "app/validators.hpp"
#include "controller/campaign_table.hpp"

namespace ferrule {

void VariedArguments::add_controller(CLI::App& verb) {
  verb.add_option("controller", controller, kControllers)->type_name(kControllerType)->required();
}

void VariedArguments::add_options(CLI::App& verb, SharedJob& shared, const std::string& trials_help,
                                  bool shards_wait) {
  job = &shared;
  scene.add_to(verb, "that of the controller's training, or demo");
  add_other_scaling(verb, other_scaling);
  verb.add_option("--trials", trials, trials_help)
      ->capture_default_str()
      ->check(whole_number(1, 100000000));
  add_seed(verb, seed, "Seed of the trials, the same for all scenes");
  add_threads(verb, threads);
  add_shard(verb, shared, shards_wait);
}

VariedScene::VariedScene(const VariedArguments& arguments)
    : arguments_(arguments), given_(given_controller(arguments.controller, {}, arguments.seed)) {
  if (given_.file) brought_ = brought_by(trained_on(*given_.file), arguments.controller);
}

ChosenScene VariedScene::with(const std::vector<std::string>& settings) const {
  SceneArguments scene = arguments_.scene;
  scene.settings.insert(scene.settings.end(), settings.begin(), settings.end());
  ChosenScene chosen = scene.choose(brought_);
  if (given_.file)
    refuse_other_scaling(trained_on(*given_.file).scaling, arguments_.controller, chosen.scene,
                         arguments_.other_scaling);
  return chosen;
}

Provenance VariedScene::provenance(const ChosenScene& chosen) const {
  Provenance provenance;
  provenance.in(chosen).seed("trials", arguments_.seed);
  if (!given_.read.empty()) provenance.read(given_.read);
  return provenance;
}

void run(const VariedArguments& a, const VariedScene& varied, const StoppingArguments& stopping,
         std::vector<Point*> points, const std::function<bool()>& stop) {
  std::erase_if(points, [](const Point* point) { return !point->scene; });
  std::vector<Campaign> campaigns;
  for (const Point* point : points)
    campaigns.push_back({.scene = &*point->scene,
                         .make = varied.controller(*point->scene),
                         .enough = when(stopping.enough),
                         .redrawn = point->redrawn});
  const std::string what = fmt::format("{} scenes", points.size());
  std::vector<std::vector<TrialResult>> results =
      run_campaigns(campaigns, a.seed, a.trials, a.threads,
                    Progress(what, points.size() * a.trials), stop, a.job->store.get());
  for (std::size_t k = 0; k < points.size(); ++k) {
    Point& point = *points[k];
    point.results = std::move(results[k]);
    point.summary = stopping.summary(point.results);
    point.summary.mated = mated(*point.scene, point.results, a.seed);
  }
}

Json short_row(const Json& summary) {
  Json row;
  for (const char* key : {"trials", "feasible", "successes", "success_rate"})
    row[key] = summary[key];
  row["low"] = summary["wilson_low"];
  row["high"] = summary["wilson_high"];
  for (const auto& [name, key, p95] : {std::tuple{"time_s", "time_s", "time_p95_s"},
                                       {"peak_force_uN", "peak_force_uN", "peak_force_p95_uN"},
                                       {"loss_dB", "loss_dB", "loss_p95_dB"}}) {
    row[name] = summary[key]["median"];
    row[p95] = summary[key]["p95"];
  }
  for (const char* key : {"outcomes", "target", "mated", "mated_tuned", "mated_joint"})
    if (summary.contains(key)) row[key] = summary[key];
  return row;
}

Json to_json(const Point& point) {
  Json row = short_row(to_json(point.summary));
  row["values"] = point.values;
  if (point.scene) row["damage"] = damage_json(*point.scene);
  return row;
}

}  // namespace ferrule
