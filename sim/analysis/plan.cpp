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

constexpr int kFullNodes = 16;          // of the quadrature of the full model
constexpr double kInertialStep = 5e-6;  // its longest with inertia [s]

constexpr double kShare = 0.2;  // of the tolerance that all that is left out may take
constexpr double kShareWhereItSticks = 1e-4;
constexpr double kShareOfInertia = 0.8;     // which it may change where it is left out unmeasured
constexpr double kMeasured = 0.3;           // of the tolerance that the chosen model may miss by
constexpr double kMeasuredWithDrag = 0.05;  // how a fibre slips out of a liquid differs more

constexpr double kLocatesEvents = 1e-9;   // the hand's travel in one that is located, at most [m]
constexpr double kFinestForSteps = 1e-4;  // what a step with drag is compared with [s]
constexpr double kTangent = 0.3;          // of the tolerance, along a tangent for the success rate

// A model to choose.
struct Reduced {
  std::vector<Term> without;
  std::optional<double> tangent;  // [-]; none: as the scene has it
  double error = INFINITY;        // largest that is to be expected: measured over its share
};

// Terms that may be left out together, the smallest first.
std::vector<Term> small_terms(const Reference& reference, double enough) {
  const auto change = [&](Term term) { return reference.changes_without(term); };
  std::vector<Term> order;
  for (const Term term : kAllTerms)  // one that was not seen may act elsewhere; walls are no choice
    if (info(term).read && info(term).present(reference.scene.world.laws) && change(term) > 0)
      order.push_back(term);
  std::sort(order.begin(), order.end(),
            [&](Term a, Term b) { return std::pair(change(a), a) < std::pair(change(b), b); });
  double all = 0;
  const auto first_kept = std::find_if(order.begin(), order.end(),
                                       [&](Term term) { return (all += change(term)) > enough; });
  order.erase(first_kept, order.end());
  return order;
}

// In steps of at most `step` [s].
World reduced_world(const Reference& reference, const Reduced& r, double step) {
  WorldParameters p = reference.scene.parameters;
  for (const Term term : r.without) info(term).leave_out(p.laws);
  p.numerics.longest_step = step;
  if (r.tangent) {
    p.numerics.extrapolation_tip = *r.tangent * reference.clearance;
    p.numerics.extrapolation_force = *r.tangent * reference.force_scale;
  }
  return make_world(p);
}

// The scene file of that model.
Json reduced_document(const Reference& reference, const Reduced& r, const Plan& plan) {
  Json d = reference.scene.document();
  d.erase("accuracy");
  d.erase("tilted_axes");
  for (const Term term : r.without) d["laws"][info(term).name] = nullptr;
  d["quadrature"] = kFullNodes;
  const bool inertial = plan.dynamics == Dynamics::inertial;
  d["dynamics"] = inertial ? "inertial" : "quasi_static";
  if (inertial) d["integrator"] = "bdf2";
  d["step_s"] = plan.step;
  // Which depends on the laws where it is not stated.
  if (!d.contains("event_travel_nm"))
    d["event_travel_nm"] = std::min(reference.scene.parameters.numerics.event_travel / 1e-9, 1e9);
  if (r.tangent)
    d["tangent"] = {{"tip_nm", *r.tangent * reference.clearance / 1e-9},
                    {"force_uN", *r.tangent * reference.force_scale / 1e-6}};
  for (const PlannedTerm& term : plan.terms) {
    if (term.name != "curl" || term.kept) continue;
    d["fibre"].erase("curl_radius_m");
    if (!d["fibre"].contains("cleave_deg")) d["fibre"].erase("roll_deg");  // which turns both
  }
  d["planned_accuracy"] = plan.tolerance;
  d["planned_error_bound"] = plan.error_bound;
  return d;
}

// With the small terms left out, if there are any; with all.
std::vector<std::vector<Term>> with_and_without(const Reference& reference, double enough) {
  std::vector<std::vector<Term>> choices = {small_terms(reference, enough)};
  if (!choices.front().empty()) choices.emplace_back();
  return choices;
}

// The first of the models whose error is at most the share `measured` of the tolerance; else the
// last.
template <class Error>
Reduced choose(std::vector<Reduced> models, double tolerance, double measured, const Error& error) {
  for (Reduced& model : models) {
    model.error = error(model);
    const bool enough = model.error <= measured * tolerance;
    model.error /= measured;
    if (enough) return model;
  }
  return models.back();
}

Reduced choose_for_motion(const Reference& reference, double tolerance, double step) {
  std::vector<Reduced> models;
  const double share = reference.sticks ? kShareWhereItSticks : kShare;
  for (const auto& without : with_and_without(reference, share * tolerance))
    models.push_back({without, {}});
  const WorldParameters& full = reference.scene.parameters;
  const double measured = depends_on_speed(full.laws) ? kMeasuredWithDrag : kMeasured;
  return choose(std::move(models), tolerance, measured, [&](const Reduced& r) {
    if (r.without.empty() && step == full.numerics.longest_step) return 0.0;  // the full model
    return reference.error(reduced_world(reference, r, step));
  });
}

Reduced choose_for_success(const Reference& reference, double tolerance) {
  std::vector<Reduced> models;
  for (const auto& without : with_and_without(reference, kShare * tolerance))
    for (const double part : {kTangent, 0.1 * kTangent})
      models.push_back({without, part * tolerance});
  models.emplace_back();
  const bool timeless = !depends_on_speed(reference.scene.world.laws);
  const World exact =
      reduced_world(reference, {{}, 0.0}, timeless ? kControlPeriod : kFinestForSteps);
  return choose(std::move(models), tolerance, kMeasured, [&](const Reduced& r) {
    return reference.error_of_steps(reduced_world(reference, r, kControlPeriod), exact);
  });
}

std::vector<PlannedTerm> planned_terms(const Reference& reference, const std::vector<Term>& without,
                                       const World& chosen) {
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

  Inertia(const Scene& scene, double tolerance) : stated(scene.document().contains("dynamics")) {
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

// Every term, the finest fidelity.
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

// What is in no table of terms.
void add_curl_and_inertia(const Reference& reference, const Inertia& inertia, double share,
                          Plan& plan) {
  if (const auto curl = free_curl(reference.scene.parameters)) {
    plan.terms.push_back(planned_curl(*curl, reference, share * plan.tolerance));
    plan.error_bound += plan.terms.back().relative_error;
  }
  if (inertia.stated && plan.dynamics != Dynamics::inertial) return;
  const bool kept = plan.dynamics == Dynamics::inertial;
  plan.terms.push_back({"inertia", kept, kept ? "second order (BDF2)" : "none", inertia.force,
                        kept ? 0 : inertia.change, State()});
  if (!inertia.stated) plan.error_bound += plan.terms.back().relative_error;
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
  const double step = for_success
                          ? kControlPeriod
                          : std::min(scene.parameters.numerics.longest_step, kControlPeriod);
  Scene full = full_model(scene, inertial,
                          inertial           ? std::min(step / kFiner, kInertialStep)
                          : dragged && !rubs ? step / kFiner
                                             : step);
  const std::size_t probes = probes_of(full);
  Runs runs{go_on, kResampled + probes + (for_success ? 5 * kProbesForSteps : (2 + rubs) * probes)};
  const Reference reference(std::move(full), runs);
  const double of_intervals = rubs ? reference.error_of_intervals() / kMeasured : 0;
  const Reduced chosen =
      for_success ? choose_for_success(reference, left) : choose_for_motion(reference, left, step);
  const World world = reduced_world(reference, chosen, step);

  Plan plan;
  plan.tolerance = tolerance;
  plan.rings = inertia.rings;
  plan.dynamics = world.dynamics;
  plan.step = step;
  plan.force_scale = reference.force_scale;
  plan.step_error = std::max(chosen.error, of_intervals);
  for (const Term term : chosen.without) plan.error_bound += reference.changes_without(term);
  plan.error_bound = std::max(plan.error_bound, plan.step_error);
  plan.sampled_twice = reference.sampled_twice();
  plan.partial = runs.stopped;
  plan.sampling_counts = scene.document().contains("event_travel_nm") && !for_success &&
                         scene.parameters.numerics.event_travel > 1.001 * kLocatesEvents;
  if (plan.sampling_counts) plan.error_bound = std::max(plan.error_bound, plan.sampled_twice);
  if (!inertial) plan.tangent = world.numerics.extrapolation_tip / reference.clearance;
  plan.terms = planned_terms(reference, chosen.without, world);
  add_curl_and_inertia(reference, inertia, reference.sticks ? kShareWhereItSticks : kShare, plan);
  if (plan.partial) plan.error_bound = INFINITY;
  plan.document = reduced_document(reference, chosen, plan);
  return plan;
}

Scene planned(const Scene& scene, const PlanProgress& go_on) {
  if (!scene.accuracy) return scene;
  return parse_scene(make_plan(scene, *scene.accuracy, go_on).document, scene.name);
}

}  // namespace ferrule
