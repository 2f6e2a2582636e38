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

struct Arguments {
  SceneArguments scene;
  std::string controller, baseline;
  std::size_t trials = 1000;
  std::uint64_t seed = 7;
  int threads = 0;
  bool supervise = false, json = false;
};

Json spread_json(const Spread& s, double unit) {
  return {{"median", number_or_null(unit * s.median)}, {"p95", number_or_null(unit * s.p95)}};
}

int evaluate_verb(const Arguments& a) {
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
      if (!a.json)
        fmt::print(
            "same trials: {:+.1f} percentage points (95 % {:+.1f} to {:+.1f}), McNemar p = "
            "{:.2g}\n",
            100 * comparison.difference, 100 * comparison.interval.low,
            100 * comparison.interval.high, comparison.mcnemar_p);
    }
  }
  if (a.json) print_json(json);
  return kDone;
}

Json to_json(const InterventionSummary& s) {
  Json kinds = Json::object(), gave_up = Json::object();
  for (std::size_t i = 0; i < kInterventions; ++i) {
    kinds[kInterventionNames[i]] = {{"count", s.kinds[i].count}, {"trials", s.kinds[i].trials}};
    if (s.gave_up[i] > 0) gave_up[kInterventionNames[i]] = s.gave_up[i];
  }
  return {{"interventions", kinds}, {"trials_with_interventions", s.trials}, {"gave_up", gave_up}};
}

}  // namespace

Json to_json(const CampaignSummary& s) {
  Json outcomes = Json::object();
  for (int i = 0; i < kOutcomes; ++i)
    if (s.outcomes[static_cast<std::size_t>(i)] > 0)
      outcomes[name(static_cast<Outcome>(i))] = s.outcomes[static_cast<std::size_t>(i)];
  Json json = {{"trials", s.trials},
               {"feasible", s.feasible},
               {"successes", s.successes},
               {"success_rate", number_or_null(s.success_rate)},
               {"wilson_low", s.wilson.low},
               {"wilson_high", s.wilson.high},
               {"outcomes", outcomes},
               {"time_s", spread_json(s.time, 1)},
               {"peak_force_uN", spread_json(s.peak_force, 1e6)},
               {"loss_dB", spread_json(s.loss_dB, 1)}};
  if (s.interventions) json.update(to_json(*s.interventions));
  return json;
}

void add_json(const Comparison& c, Json& json) {
  json["difference"] = c.difference;
  json["difference_low"] = c.interval.low;
  json["difference_high"] = c.interval.high;
  json["mcnemar_p"] = c.mcnemar_p;
  const auto paired = [](const PairedMedian& p, double unit) {
    return Json{{"median", number_or_null(unit * p.median)},
                {"low", number_or_null(unit * p.interval.low)},
                {"high", number_or_null(unit * p.interval.high)}};
  };
  json["time_difference_s"] = paired(c.time, 1);
  json["peak_force_difference_uN"] = paired(c.peak_force, 1e6);
}

std::string to_text(const std::string& who, const CampaignSummary& s) {
  std::string text = fmt::format("{}: {} of {} inserted", who, s.successes, s.feasible);
  if (s.feasible > 0)
    text += fmt::format(", {:.1f} % (95 % {:.1f} to {:.1f})", 100 * s.success_rate,
                        100 * s.wilson.low, 100 * s.wilson.high);
  text += "\n";
  for (int i = 1; i < kOutcomes; ++i)
    if (const auto n = s.outcomes[static_cast<std::size_t>(i)]; n > 0)
      text += fmt::format("  {:<14} {}\n", name(static_cast<Outcome>(i)), n);
  const auto line = [&](const char* what, const Spread& spread, double unit, const char* in) {
    if (std::isfinite(spread.median))
      text += fmt::format("  {:<14} median {:.4g} {}, p95 {:.4g} {}\n", what, unit * spread.median,
                          in, unit * spread.p95, in);
  };
  line("time", s.time, 1, "s");
  line("peak force", s.peak_force, 1e6, "uN");
  line("joint loss", s.loss_dB, 1, "dB");
  if (!s.interventions) return text;
  text += fmt::format("  {:<14} in {} of {} trials\n", "interventions", s.interventions->trials,
                      s.trials);
  for (std::size_t i = 0; i < kInterventions; ++i)
    if (const auto [count, trials] = s.interventions->kinds[i]; count > 0) {
      text += fmt::format("    {:<12} {} in {} trials", kInterventionNames[i], count, trials);
      const std::size_t ended = s.interventions->gave_up[i];
      text += ended ? fmt::format(", ended {}\n", ended) : "\n";
    }
  return text;
}

void add_evaluate(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand("evaluate", "Success rate of a controller over many trials");
  auto a = std::make_shared<Arguments>();
  verb->add_option("controller", a->controller, "Controller file")->type_name("FILE.json");
  a->scene.add_to(*verb, "demo");
  verb->add_option("--trials", a->trials, "How many")
      ->capture_default_str()
      ->check(CLI::Range(std::size_t{1}, std::size_t{100000000}));
  add_seed(*verb, a->seed, "Seed of the starts");
  verb->add_option("--threads", a->threads, "0: all cores; the result does not depend on it")
      ->capture_default_str()
      ->check(CLI::Range(0, 4096));
  verb->add_option("--baseline", a->baseline, "The naive controller: alone, or on the same trials")
      ->check(CLI::IsMember({"constant-velocity"}));
  verb->add_flag("--supervise", a->supervise,
                 "Put a supervisor around every controller: limits, retreat and retry");
  verb->add_flag("--json", a->json, "One JSON document on stdout");
  verb->callback([a, &run] { run = [a] { return evaluate_verb(*a); }; });
}

}  // namespace ferrule
