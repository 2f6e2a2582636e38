// ferrule evaluate: the success rate of a controller over a campaign of trials.
#include <fmt/format.h>

#include "app/campaign_table.hpp"
#include "app/verb.hpp"
#include "capture/episode.hpp"
#include "controller/controller_file.hpp"
#include "controller/supervisor.hpp"
#include "insertion/scene_scaling.hpp"

namespace ferrule {
namespace {

struct EvaluateArguments {
  SceneArguments scene;
  std::string controller, baseline;
  std::size_t trials = 1000;
  std::uint64_t seed = 7;
  int threads = 0;
  bool supervise = false, json = false;
};

int evaluate_verb(const EvaluateArguments& a) {
  if (a.controller.empty() && a.baseline.empty())
    throw BadInput("evaluate: give a controller file, or --baseline constant-velocity, or both");
  const Scene scene = a.scene.load();
  const Scaling scaling = scene_scaling(scene);
  MakeController law;
  if (!a.controller.empty()) law = load_controller(a.controller);
  const MakeController constant =
      controller_maker(ConstantVelocity(scaling.motion * scene.limits.speed));

  const auto campaign = [&](const MakeController& make, const char* what) {
    return run_campaign(scene, scaling,
                        a.supervise ? supervised(make, supervisor_limits(scene, scaling)) : make,
                        a.seed, a.trials, a.threads, Progress(what, a.trials));
  };
  const MakeController& first = law ? law : constant;
  const std::string first_name = law ? a.controller : a.baseline;
  const std::vector<TrialResult> results = campaign(first, "trials");
  const CampaignSummary summary = summarise(results);
  Json json = {{"scene", scene.name}, {"controller", first_name}, {"seed", a.seed}};
  json.update(to_json(summary));
  if (!a.json) fmt::print("{}", to_text(first_name, summary));

  if (law && !a.baseline.empty()) {
    const std::vector<TrialResult> other = campaign(constant, "baseline");
    const CampaignSummary baseline = summarise(other);
    json["baseline"] = {{"controller", a.baseline}};
    json["baseline"].update(to_json(baseline));
    if (!a.json) fmt::print("{}", to_text(a.baseline, baseline));
    if (baseline.feasible > 0) {
      const Comparison comparison = compare(results, other);
      add_json(comparison, json["baseline"]);
      if (!a.json) fmt::print("{}", to_text(comparison));
    }
  }
  if (a.json) print_json(json);
  return kDone;
}

}  // namespace

void add_evaluate(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand("evaluate", "Success rate of a controller over many trials");
  auto a = std::make_shared<EvaluateArguments>();
  verb->add_option("controller", a->controller, "Controller file")->type_name("FILE.json");
  a->scene.add_to(*verb, "demo");
  verb->add_option("--trials", a->trials, "How many")
      ->capture_default_str()
      ->check(CLI::Range(std::size_t{1}, std::size_t{100000000}));
  add_seed(*verb, a->seed, "Seed of the starts");
  add_threads(*verb, a->threads);
  verb->add_option("--baseline", a->baseline, "The naive controller: alone, or on the same trials")
      ->check(CLI::IsMember({"constant-velocity"}));
  verb->add_flag("--supervise", a->supervise,
                 "Put a supervisor around every controller: limits, retreat and retry");
  add_json(*verb, a->json);
  verb->callback([a, &run] { run = [a] { return evaluate_verb(*a); }; });
}

}  // namespace ferrule
