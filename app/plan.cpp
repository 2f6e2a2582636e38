// ferrule plan: what a scene needs for a tolerance.
#include "sim/analysis/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/interrupt.hpp"
#include "app/output.hpp"
#include "app/progress.hpp"
#include "app/scene_arguments.hpp"
#include "app/validators.hpp"
#include "app/verbs.hpp"
#include "sim/analysis/term_cost.hpp"

namespace ferrule {
namespace {

struct PlanArguments {
  SceneArguments scene;
  double tolerance = 0.01;
  std::string tolerance_of = "motion";
  std::string out;
  Output output;
};

const char* dynamics(const Plan& plan) {
  return plan.dynamics == Dynamics::inertial ? "inertial" : "quasi_static";
}

bool holds(const Plan& plan) {
  return plan.error_bound <= plan.tolerance;
}

// `costs`: of the plan's terms [ns].
Json to_json(const Plan& plan, const std::vector<double>& costs) {
  Json terms = Json::array();
  for (std::size_t i = 0; i < plan.terms.size(); ++i) {
    const PlannedTerm& t = plan.terms[i];
    terms.push_back({{"name", t.name},
                     {"kept", t.kept},
                     {"fidelity", t.fidelity},
                     {"max_force_uN", 1e6 * t.max_force},
                     {"relative_error", t.relative_error},
                     {"cost_ns", number_or_null(costs[i])}});
  }
  return {{"tolerance", plan.tolerance},
          {"terms", terms},
          {"dynamics", dynamics(plan)},
          {"step_s", plan.step},
          {"tangent", plan.tangent},
          {"sampled_twice", plan.sampled_twice},
          {"sampling_counts", plan.sampling_counts},
          {"rings_s", number_or_null(plan.rings)},
          {"error_bound", number_or_null(plan.error_bound)}};
}

// What the judgement of inertia knows of how a fibre rings.
std::string ringing(const Plan& plan, bool inertia_kept) {
  if (std::isfinite(plan.rings))
    return fmt::format("A snap rings for {:.2g} s until it is within the tolerance{}.\n",
                       plan.rings, inertia_kept ? "" : ", which is in the bound");
  return inertia_kept ? ""
                      : "Inertia: as the hand moves; the bound does not cover how a fibre rings "
                        "after a snap.\n";
}

void print(const Plan& plan, const std::vector<double>& costs) {
  fmt::print("{:<15} {:<9} {:<28} {:>13} {:>10} {:>8}\n", "term", "", "fidelity", "largest [uN]",
             "error", "ns");
  double bound_left_out = 0;
  bool inertia = true;
  for (std::size_t i = 0; i < plan.terms.size(); ++i) {
    const PlannedTerm& t = plan.terms[i];
    if (!t.kept) bound_left_out += t.relative_error;
    inertia &= t.name != "inertia" || t.kept;
    fmt::print("{:<15} {:<9} {:<28} {:>13.4g} {:>10.2g} {:>8}\n", t.name,
               t.kept ? "kept" : "left out", t.kept ? t.fidelity : "", 1e6 * t.max_force,
               t.relative_error, number_or("-", "{:.1f}", costs[i]));
  }
  if (plan.partial) return;
  fmt::print(
      "{}, steps of {:g} ms. What is left out changes the result by at most {:.2g}.\n"
      "{}"
      "The same motion sampled and stepped twice as finely ends elsewhere by {:.2g}: {}.\n"
      "{}Error bound {:.2g} of the clearance, and of {:.4g} uN in force; asked for: {:g}{}\n",
      dynamics(plan), 1e3 * plan.step, std::min(bound_left_out, plan.error_bound),
      plan.tangent > 0
          ? fmt::format(
                "Smooth intervals are followed along the tangent, to {:.2g} of the clearance.\n",
                plan.tangent)
          : "",
      plan.sampled_twice, plan.sampling_counts ? "that counts" : "the bound does not cover that",
      ringing(plan, inertia), plan.error_bound, 1e6 * plan.force_scale, plan.tolerance,
      holds(plan)                        ? ""
      : plan.step_error > plan.tolerance ? ": NOT REACHED, its steps are too long"
                                         : ": NOT REACHED");
}

Plan planned_here(const Scene& scene, const PlanArguments& a) {
  const EndsAfter of_runs("case");  // one along an inertial fibre takes a second
  Progress progress("planning", 1);
  return make_plan(
      scene, a.tolerance,
      [&](std::size_t runs, std::size_t most) {
        progress(runs, "", most);
        return !interrupted();
      },
      a.tolerance_of == "success" ? PlanFor::success : PlanFor::motion);
}

int plan_verb(const PlanArguments& a) {
  // The tolerance asked for here, whatever the scene says.
  const Scene scene = a.scene.load();
  const Plan plan = planned_here(scene, a);
  std::vector<double> costs;
  for (const PlannedTerm& term : plan.terms)
    costs.push_back(plan.partial ? NAN : term_cost(plan, scene, term));
  if (!a.out.empty() && !plan.partial) write_text(a.out, plan.document.dump(2) + "\n");
  Provenance provenance;
  provenance.in({scene, scene_file(a.scene.name())});
  if (plan.partial) provenance.partial("the largest forces of some motions, and no plan yet");
  if (a.output.text()) {
    fmt::print("{}", provenance.head());
    print(plan, costs);
    fmt::print("{}", provenance.foot());
  }
  print_result(a.output, to_json(plan, costs), "terms", provenance);
  return plan.partial ? kInterrupted : holds(plan) ? kDone : kFailed;
}

}  // namespace

void add_plan(CLI::App& app, Run& run) {
  auto* verb =
      app.add_subcommand("plan", "Which terms, dynamics and step a scene needs for a tolerance");
  auto a = std::make_shared<PlanArguments>();
  a->scene.add_to(*verb);
  verb->add_option(
          "--tolerance", a->tolerance,
          "Error of the tip over the clearance, and of the force over the largest at the holder")
      ->capture_default_str()
      ->check(number_between(1e-6, 0.5));
  verb->add_option("--tolerance-of", a->tolerance_of,
                   "The motion's, or that of every step, which leaves a success rate as it is")
      ->capture_default_str()
      ->check(one_of({"motion", "success"}));
  verb->add_option("--out", a->out, "Write the planned scene to a file")->type_name("FILE");
  add_output(*verb, a->output);
  add_examples(*verb, {"plan --scene bench --tolerance 0.05",
                       "plan --scene bench --tolerance-of success --out planned.json",
                       "plan --scene paper --out planned.json --json"});
  verb->callback([a, &run] { run.verb = [a] { return plan_verb(*a); }; });
}

}  // namespace ferrule
