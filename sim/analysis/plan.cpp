#include "sim/analysis/plan.hpp"

#include <algorithm>
#include <cmath>

#include "sim/analysis/reference.hpp"
#include "sim/base/control_period.hpp"
#include "sim/base/elementary.hpp"
#include "sim/base/minimum_jerk.hpp"
#include "sim/laws/tilted_annulus.hpp"
#include "sim/scene/terms.hpp"
#include "sim/terms/surface_forces.hpp"

namespace ferrule {
namespace {

constexpr int kFullNodes = 16;  // of the quadrature of the full model

// Steps to choose from [s]; the last is the full model's. Without drag and inertia nothing depends
// on time, and the control period is the step. A system with inertia rings: it is stepped much
// finer, along shorter probes.
const std::vector<double> kTimeless = {1e-3};
const std::vector<double> kDragSteps = {1e-3, 5e-4, 2.5e-4, 1e-4, 5e-5};
const std::vector<double> kInertialSteps = {1e-3, 1e-4, 2e-5, 1e-5, 5e-6};

constexpr double kShare = 0.2;  // of the tolerance that all that is left out may take
constexpr double kShareWhereItSticks = 1e-4;
constexpr double kShareOfInertia = 0.8;     // which it may change where it is left out unmeasured
constexpr double kMeasured = 0.3;           // of the tolerance that the chosen model may miss by
constexpr double kMeasuredWithDrag = 0.05;  // how a fibre slips out of a liquid differs more

constexpr double kLocatesEvents = 1e-9;   // the hand's travel in one that is located, at most [m]
constexpr double kFinestForSteps = 1e-4;  // what a step with drag is compared with [s]
constexpr double kTangent = 0.3;          // of the tolerance, along a tangent for the success rate

// Terms that may be left out together, and what that changes at most.
struct LeftOut {
  std::vector<Term> terms;
  double change = 0;
};

LeftOut smallest_terms(const Reference& reference, double enough) {
  const auto change = [&](Term term) { return reference.changes_without(term); };
  std::vector<Term> order;
  for (const Term term : kAllTerms)  // one that was not seen may act elsewhere; walls are no choice
    if (info(term).read && info(term).present(reference.scene.world.laws) && change(term) > 0)
      order.push_back(term);
  std::sort(order.begin(), order.end(),
            [&](Term a, Term b) { return std::pair(change(a), a) < std::pair(change(b), b); });
  LeftOut out;
  for (const Term term : order) {
    const double more = change(term);
    if (out.change + more > enough) break;
    out.change += more;
    out.terms.push_back(term);
  }
  return out;
}

// A model to choose.
struct Reduced {
  std::vector<Term> without;
  Dynamics dynamics;
  double step;                         // longest [s]
  std::optional<double> tangent = {};  // [-]; none: as the scene has it
};

World reduced_world(const Reference& reference, const Reduced& r) {
  WorldParameters p = reference.scene.parameters;
  for (const Term term : r.without) info(term).leave_out(p.laws);
  p.dynamics = r.dynamics;
  if (r.dynamics == Dynamics::quasi_static) p.numerics.integrator = Integrator::backward_euler;
  p.numerics.longest_step = r.step;
  if (r.tangent) {
    p.numerics.extrapolation_tip = *r.tangent * reference.clearance;
    p.numerics.extrapolation_force = *r.tangent * reference.force_scale;
  }
  return make_world(p);
}

// The scene file of that model.
Json reduced_document(const Reference& reference, const Reduced& r) {
  Json d = reference.scene.document;
  for (const char* key : {"accuracy", "tilted_axes", "integrator"}) d.erase(key);
  for (const Term term : r.without) d["laws"][info(term).name] = nullptr;
  d["quadrature"] = kFullNodes;
  const bool inertial = r.dynamics == Dynamics::inertial;
  d["dynamics"] = inertial ? "inertial" : "quasi_static";
  if (inertial) d["integrator"] = "bdf2";
  d["step_s"] = r.step;
  // Which depends on the laws where it is not stated.
  if (!d.contains("event_travel_nm"))
    d["event_travel_nm"] = std::min(reference.scene.parameters.numerics.event_travel / 1e-9, 1e9);
  if (r.tangent)
    d["tangent"] = {{"tip_nm", *r.tangent * reference.clearance / 1e-9},
                    {"force_uN", *r.tangent * reference.force_scale / 1e-6}};
  return d;
}

// The chosen model, with what it leaves out.
struct Choice {
  Reduced model;
  LeftOut left_out;
  double error;  // largest that is to be expected: that measured over the share it may have
};

// The full model without the terms that are small enough, where there are any, and with all of
// them.
std::vector<Choice> with_and_without_terms(const Reference& reference, const Choice& full,
                                           double share) {
  std::vector<Choice> choices = {full};
  LeftOut small = smallest_terms(reference, share);
  if (small.terms.empty()) return choices;
  choices.insert(choices.begin(), full);
  choices.front().model.without = small.terms;
  choices.front().left_out = std::move(small);
  return choices;
}

// What may be spent, of the tolerance, and which steps there are to choose from.
struct Budget {
  double tolerance;           // for all but inertia that is left out unmeasured
  bool try_quasi_static;      // in place of the full model's inertia
  std::vector<double> steps;  // [s], the last is the full model's

  std::size_t most_runs(std::size_t probes) const {
    return probes * (1 + (steps.size() > 1) + 2 * (try_quasi_static + steps.size()));
  }
};

// What is left out where that is good enough, else with every term; then the longest step.
Choice choose(const Reference& reference, const Budget& budget) {
  const World& world = reference.scene.world;
  const double measured = depends_on_speed(world.laws) ? kMeasuredWithDrag : kMeasured;
  const double enough = measured * budget.tolerance;
  const double share = (reference.sticks ? kShareWhereItSticks : kShare) * budget.tolerance;
  const Choice full{{{}, world.dynamics, budget.steps.back()}, {}, INFINITY};

  // How wrong the full model's own step is, the next longer one tells. Where that is too much, no
  // step of the list is fine enough to leave anything out beside it.
  double full_error = 0;
  if (budget.steps.size() > 1) {
    Reduced longer = full.model;
    longer.step = budget.steps[budget.steps.size() - 2];
    full_error = reference.error(reduced_world(reference, longer), INFINITY);
  }
  Choice nothing_reduced = full;
  nothing_reduced.error = full_error / measured;
  if (full_error > enough) {
    if (world.dynamics == Dynamics::quasi_static) {  // then as the scene has it, which is no worse
      Reduced& as_it_is = nothing_reduced.model;
      as_it_is.step = reference.scene.document.value("step_s", kControlPeriod);
      const double error = reference.error(reduced_world(reference, as_it_is), enough);
      nothing_reduced.error = std::max(error, full_error) / measured;
    }
    return nothing_reduced;
  }

  for (Choice& c : with_and_without_terms(reference, full, share)) {
    std::vector<std::pair<Dynamics, double>> ways;
    if (budget.try_quasi_static) ways.emplace_back(Dynamics::quasi_static, budget.steps.front());
    for (const double step : budget.steps) ways.emplace_back(world.dynamics, step);
    const bool as_full = budget.steps.size() == 1 && c.left_out.terms.empty();
    for (const auto& [dynamics, step] : ways) {
      c.model.dynamics = dynamics;
      c.model.step = step;
      c.error = as_full ? 0 : reference.error(reduced_world(reference, c.model), enough);
      if (c.error > enough) continue;
      if (step == budget.steps.back()) c.error = std::max(c.error, full_error);
      c.error /= measured;
      return c;
    }
  }
  return nothing_reduced;
}

// The cheapest model whose steps are good enough, by whether terms are left out and how closely
// intervals are followed along the tangent, at the control period; else the full one.
Choice choose_for_success(const Reference& reference, double tolerance) {
  const Scene& scene = reference.scene;
  const double enough = kMeasured * tolerance;
  const Choice full{{{}, scene.world.dynamics, kControlPeriod}, {}, INFINITY};
  Reduced finest = full.model;
  finest.tangent = 0;
  if (depends_on_speed(scene.world.laws)) finest.step = kFinestForSteps;
  const World exact = reduced_world(reference, finest);
  for (Choice& c : with_and_without_terms(reference, full, kShare * tolerance)) {
    for (const double part : {kTangent, 0.1 * kTangent}) {
      c.model.tangent = part * tolerance;
      c.error = reference.error_of_steps(reduced_world(reference, c.model), exact);
      if (c.error > enough) continue;
      c.error /= kMeasured;
      return c;
    }
  }
  Choice nothing_reduced = full;
  nothing_reduced.error = reference.error_of_steps(scene.world, exact) / kMeasured;
  return nothing_reduced;
}

std::vector<PlannedTerm> planned_terms(const Reference& reference, const Choice& choice,
                                       const World& chosen) {
  const std::vector<Term>& without = choice.left_out.terms;
  std::vector<PlannedTerm> terms;
  for (const Term term : kAllTerms) {
    if (!info(term).present(reference.scene.world.laws)) continue;
    PlannedTerm planned;
    planned.name = info(term).name;
    planned.kept = std::find(without.begin(), without.end(), term) == without.end();
    planned.fidelity = planned.kept ? info(term).fidelity(chosen) : "none";
    planned.max_force = reference.extreme(term).force;
    planned.state = reference.extreme(term).where;
    planned.relative_error = 0;
    if (!planned.kept) planned.relative_error = reference.changes_without(term);
    if (planned.kept && term == Term::electrostatic && electrostatic_in_closed_form(chosen))
      planned.relative_error += closed_form_error(chosen.annulus);
    terms.push_back(planned);
  }
  return terms;
}

// Inertia, where the scene does not say whether it is modelled.
struct Inertia {
  bool stated;    // by the scene
  double force;   // that speeds the fibre up as the hand moves [N]
  double change;  // what leaving it out changes [-]
  double rings;   // how long a clearance rings until it is within the tolerance [s]

  Inertia(const Scene& scene, double tolerance) : stated(scene.document.contains("dynamics")) {
    const Holder& holder = scene.world.holder;
    const double mass = holder.mass.topLeftCorner<3, 3>().norm();
    const double clearance = scene.world.annulus.clearance(), speed = scene.limits.speed;
    force = mass * kPeakOfMinimumJerk * speed / kSpeedingUp;
    change = force * holder.compliance() / clearance;
    const auto* elastic = std::get_if<ElasticFibre>(&scene.parameters.holder);
    const double loss = elastic ? elastic->loss_factor : 0;
    rings = -2 * elementary::log(tolerance) / (loss * holder.bending_frequency());
    if (loss > 0) change = std::max(change, speed * rings / clearance);
  }
};

// Every term, the finest fidelity; in steps as the scene has them.
Scene full_model(const Scene& scene, bool inertial, double step) {
  Scene full = scene;
  WorldParameters& p = full.parameters;
  if (inertial) {
    p.dynamics = Dynamics::inertial;
    p.numerics.integrator = Integrator::bdf2;
  }
  p.numerics.closed_form = true;
  p.numerics.quadrature = Quadrature::gauss_legendre(kFullNodes);
  p.numerics.longest_step = step;
  full.world = make_world(p);
  return full;
}

// With the longest steps that are good enough; where none are, with those of the scene, which are
// no worse.
Reference reference_in_longest_steps(const Scene& scene, double enough, Runs& watch) {
  const auto in_steps = [&](double step) {
    Reference r(full_model(scene, false, step), watch);
    r.step_error = r.error_of_intervals();
    return r;
  };
  double per_step = 0;  // the error, which falls with it
  for (const double step : kDragSteps) {
    if (per_step * step > enough) continue;
    Reference r = in_steps(step);
    if (r.step_error <= enough || watch.stopped) return r;
    per_step = r.step_error / step;
  }
  return in_steps(scene.document.value("step_s", kControlPeriod));
}

// Curl is a matter of where an insertion starts: what leaving it out changes is how far aside the
// end would lie, and what holds it straight.
PlannedTerm planned_curl(const FreeCurl& curl, const Reference& reference, double enough) {
  PlannedTerm planned{"curl", true, "offset and tilt of the free end", curl.force, 0, State()};
  const double change = std::max(curl.aside / reference.clearance, reference.changes(curl.force));
  if (change > enough) return planned;
  planned.kept = false;
  planned.fidelity = "none";
  planned.relative_error = change;
  return planned;
}

// The roll turns a cleaved end besides.
void leave_out_curl(Json& fibre) {
  fibre.erase("curl_radius_m");
  if (!fibre.contains("cleave_deg")) fibre.erase("roll_deg");
}

// What is in no table of terms.
void add_curl_and_inertia(const Reference& reference, const Choice& choice, const Inertia& inertia,
                          Plan& plan) {
  if (const auto curl = free_curl(reference.scene.parameters)) {
    plan.terms.push_back(planned_curl(
        *curl, reference, (reference.sticks ? kShareWhereItSticks : kShare) * plan.tolerance));
    plan.error_bound += plan.terms.back().relative_error;
  }
  if (inertia.stated && reference.scene.world.dynamics != Dynamics::inertial) return;
  // Where the scene has it, what leaving it out changes is measured.
  const bool kept = plan.dynamics == Dynamics::inertial;
  const double change = kept ? 0 : inertia.stated ? choice.error : inertia.change;
  plan.terms.push_back(
      {"inertia", kept, kept ? "second order (BDF2)" : "none", inertia.force, change, State()});
  if (!inertia.stated) plan.error_bound += change;
}

}  // namespace

Plan make_plan(const Scene& scene, double tolerance, const PlanProgress& go_on, PlanFor quantity) {
  if (!(tolerance >= 1e-6 && tolerance <= 0.5))
    throw BadInput("accuracy = " + Json(tolerance).dump() + ": must be from 1e-6 to 0.5");
  const Inertia inertia(scene, tolerance);
  const bool rings = !inertia.stated && inertia.change > kShareOfInertia * tolerance;
  const bool inertial = rings || scene.world.dynamics == Dynamics::inertial;
  const bool for_success = quantity == PlanFor::success && !inertial;
  const double left = inertia.stated || rings ? tolerance : tolerance - inertia.change;
  const Laws& laws = scene.world.laws;
  const bool dragged = depends_on_speed(laws) && !inertial && !for_success;
  const bool rubs = dragged && (present(laws.friction) || present(laws.adhesion));
  Budget budget{left, inertial && inertia.stated,
                inertial           ? kInertialSteps
                : dragged && !rubs ? kDragSteps
                                   : kTimeless};
  Scene full = full_model(scene, inertial, budget.steps.back());
  const std::size_t probes = probes_of(full);
  const std::size_t of_intervals = rubs ? 2 * (1 + kDragSteps.size()) * probes : 0;
  Runs runs{go_on, kResampled + (for_success ? probes + 5 * kProbesForSteps
                                             : budget.most_runs(probes) + of_intervals)};
  const Reference reference = rubs ? reference_in_longest_steps(scene, kMeasured * left, runs)
                                   : Reference(std::move(full), runs);
  budget.steps.back() = reference.scene.parameters.numerics.longest_step;
  const Choice choice =
      for_success ? choose_for_success(reference, left) : choose(reference, budget);

  Plan plan;
  plan.partial = runs.stopped;
  plan.tolerance = tolerance;
  plan.rings = inertia.rings;
  plan.dynamics = choice.model.dynamics;
  plan.step = choice.model.step;
  plan.force_scale = reference.force_scale;
  plan.step_error = std::max(choice.error, reference.step_error / kMeasured);
  plan.error_bound = std::max(plan.step_error, choice.left_out.change);
  plan.sampled_twice = reference.sampled_twice();
  plan.sampling_counts = reference.scene.document.contains("event_travel_nm") && !for_success &&
                         reference.scene.parameters.numerics.event_travel > 1.001 * kLocatesEvents;
  if (plan.sampling_counts) plan.error_bound = std::max(plan.error_bound, plan.sampled_twice);
  const World chosen = reduced_world(reference, choice.model);
  if (chosen.dynamics == Dynamics::quasi_static)
    plan.tangent = chosen.numerics.extrapolation_tip / reference.clearance;
  plan.terms = planned_terms(reference, choice, chosen);
  add_curl_and_inertia(reference, choice, inertia, plan);
  if (plan.partial) plan.error_bound = INFINITY;
  plan.document = reduced_document(reference, choice.model);
  for (const PlannedTerm& term : plan.terms)
    if (term.name == "curl" && !term.kept) leave_out_curl(plan.document["fibre"]);
  plan.document["planned_accuracy"] = tolerance;
  plan.document["planned_error_bound"] = plan.error_bound;
  return plan;
}

Scene planned(const Scene& scene, const PlanProgress& go_on) {
  if (!scene.accuracy) return scene;
  return parse_scene(make_plan(scene, *scene.accuracy, go_on).document, scene.name);
}

}  // namespace ferrule
