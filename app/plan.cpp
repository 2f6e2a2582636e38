#include "sim/plan/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/verb.hpp"
#include "bench/measure.hpp"
#include "sim/potential.hpp"

namespace ferrule {
namespace {

struct Arguments {
  SceneArguments scene;
  double tolerance = 0.01;
  std::string out;
  bool json = false;
};

// A world that models one of the terms, or with "" none.
World with_only(const Plan& plan, const Scene& scene, const std::string& name) {
  Json document = plan.document;
  document.erase("planned_accuracy");
  for (auto& [law, value] : document["laws"].items()) {
    const bool this_one = law == name;
    value = this_one ? scene.document["laws"][law] : Json();
  }
  document["dynamics"] = name == "inertia" ? "inertial" : "quasi_static";
  World world = parse_scene(document, scene.name).world;
  if (name == "wall")
    world.laws.wall = scene.world.laws.wall;
  else
    world.laws.wall.reset();
  return world;
}

// What a term adds to what a smooth step needs, to prepare the potential and evaluate it once,
// where it is strongest [ns]: both timed in turns, so that neither is the one that was disturbed.
double cost(const Plan& plan, const Scene& scene, const PlannedTerm& term) {
  constexpr int kTurns = 8;
  const World with = with_only(plan, scene, term.name), without = with_only(plan, scene, "");
  const auto time = [&](const World& world) {
    return nanoseconds_per_call(
        [&](long) {
          const FrozenCoefficients frozen =
              freeze(world, term.state, term.state.command, plan.step);
          keep(Potential(world, frozen, term.state.tip));
        },
        2e5);
  };
  double most = time(with), least = time(without);
  for (int turn = 1; turn < kTurns; ++turn) {
    most = std::min(most, time(with));
    least = std::min(least, time(without));
  }
  return std::max(0.0, most - least);
}

int plan_scene(const Arguments& a) {
  // The tolerance asked for here, whatever the scene says.
  const Scene scene = load_scene(a.scene.scene, a.scene.settings);
  const Plan plan = make_plan(scene, a.tolerance);
  std::vector<double> costs;
  for (const PlannedTerm& t : plan.terms) costs.push_back(cost(plan, scene, t));
  if (!a.out.empty()) write_text(a.out, plan.document.dump(2) + "\n");

  bool inertia_left_out = false;
  for (const PlannedTerm& t : plan.terms) inertia_left_out |= t.name == "inertia" && !t.kept;
  const bool holds = plan.error_bound <= plan.tolerance;
  const char* dynamics = plan.dynamics == Dynamics::inertial ? "inertial" : "quasi_static";
  if (a.json) {
    Json terms = Json::array();
    for (std::size_t i = 0; i < plan.terms.size(); ++i) {
      const PlannedTerm& t = plan.terms[i];
      terms.push_back({{"name", t.name},
                       {"kept", t.kept},
                       {"fidelity", t.fidelity},
                       {"max_force_uN", 1e6 * t.max_force},
                       {"relative_error", t.relative_error},
                       {"cost_ns", costs[i]}});
    }
    print_json({{"tolerance", plan.tolerance},
                {"terms", terms},
                {"dynamics", dynamics},
                {"step_s", plan.step},
                {"error_bound", plan.error_bound}});
    return holds ? kDone : kFailed;
  }
  fmt::print("{:<15} {:<9} {:<28} {:>13} {:>10} {:>8}\n", "term", "", "fidelity", "largest [uN]",
             "error", "ns");
  double bound_left_out = 0;
  for (std::size_t i = 0; i < plan.terms.size(); ++i) {
    const PlannedTerm& t = plan.terms[i];
    if (!t.kept) bound_left_out += t.relative_error;
    fmt::print("{:<15} {:<9} {:<28} {:>13.4g} {:>10.2g} {:>8.1f}\n", t.name,
               t.kept ? "kept" : "left out", t.kept ? t.fidelity : "", 1e6 * t.max_force,
               t.relative_error, costs[i]);
  }
  fmt::print(
      "{}, steps of {:g} ms. What is left out changes the result by at most {:.2g}.\n"
      "For a hand sampled at 1 kHz: where the fibre snaps or sticks, finer sampling ends "
      "elsewhere.\n"
      "{}Error bound {:.2g} of the clearance, and of {:.4g} uN in force; asked for: {:g}{}\n",
      dynamics, 1e3 * plan.step, std::min(bound_left_out, plan.error_bound),
      inertia_left_out ? "Inertia: as the hand moves; how a fibre rings after a snap is not looked "
                         "at.\n"
                       : "",
      plan.error_bound, 1e6 * plan.force_scale, plan.tolerance, holds ? "" : ": NOT REACHED");
  return holds ? kDone : kFailed;
}

}  // namespace

void add_plan(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand(
      "plan", "Which terms, fidelity, dynamics and step a scene needs for a tolerance");
  auto a = std::make_shared<Arguments>();
  a->scene.add_to(*verb, "paper");
  verb->add_option(
          "--tolerance", a->tolerance,
          "Error of the tip over the clearance, and of the force over the largest at the holder")
      ->capture_default_str()
      ->check(number_between(1e-6, 0.5));
  verb->add_option("--out", a->out, "Write the planned scene to a file")->type_name("FILE");
  verb->add_flag("--json", a->json, "One JSON document on stdout");
  verb->callback([a, &run] { run = [a] { return plan_scene(*a); }; });
}

}  // namespace ferrule
