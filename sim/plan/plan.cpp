#include "sim/plan/plan.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "sim/laws/tilted_annulus.hpp"
#include "sim/minimum_jerk.hpp"
#include "sim/plan/fidelity.hpp"
#include "sim/plan/probe.hpp"
#include "sim/plan/sampled_run.hpp"

namespace ferrule {
namespace {

// Places in kTermNames.
constexpr int kWallTerm = 5, kFrictionTerm = 6;

constexpr int kFullNodes = 16;                // of the quadrature of the full model
constexpr std::size_t kEveryForFidelity = 7;  // samples at which fidelities are compared

// Steps to choose from [s]; the last is the full model's. Without drag and inertia nothing depends
// on time, and the control period is the step. A system with inertia rings: it is stepped much
// finer, along shorter probes.
const std::vector<double> kTimeless = {1e-3};
const std::vector<double> kDragSteps = {1e-3, 5e-4, 2.5e-4, 1e-4, 5e-5};
const std::vector<double> kInertialSteps = {1e-3, 1e-4, 2e-5, 1e-5, 5e-6};

constexpr double kShare = 0.2;  // of the tolerance that all that is left out may take
constexpr double kShareWhereItSticks = 1e-4;
constexpr double kShareOfFidelity = 0.2;
constexpr double kShareOfInertia = 0.8;     // which it may change where it is left out unmeasured
constexpr double kMeasured = 0.3;           // of the tolerance that the chosen model may miss by
constexpr double kMeasuredWithDrag = 0.05;  // how a fibre slips out of a liquid differs more

Scene changed(const Scene& scene, const std::function<void(Json&)>& change) {
  Json document = scene.document;
  change(document);
  return parse_scene(document, scene.name);
}

bool has_term(const World& w, int term) {
  const std::array<bool, kTerms> there = {
      w.van_der_waals.has_value(), w.electrostatic.has_value(), w.gravity.has_value(),
      w.capillary.has_value(),     w.adhesion.has_value(),      w.wall.has_value(),
      w.friction.has_value(),      w.drag.has_value(),          w.meniscus.has_value()};
  return there[static_cast<std::size_t>(term)];
}

// The full model along its probes: what every reduced one is measured against.
struct Reference {
  const Scene& scene;
  std::vector<Probe> probes;
  std::vector<SampledRun> runs;       // of each probe
  std::vector<State> inside;          // some of their states with the end in the bore
  std::array<double, kTerms> most{};  // the largest force of each term [N]
  std::array<State, kTerms> where;    // and where it was
  double compliance;                  // of the holder [m/N]
  double clearance;                   // [m]
  double force_scale = INFINITY;      // what force errors are relative to [N]
  bool sticks = false;                // or snaps

  explicit Reference(const Scene& full);
  // What a missing force [N] can change: the felt force, and where the end is [-].
  double changes(double force) const {
    return force * std::max(1 / force_scale, compliance / clearance);
  }
  // The largest error of a reduced model in any probe, or the first beyond `enough`.
  double error(const World& reduced, double enough) const;
};

Reference::Reference(const Scene& full)
    : scene(full),
      compliance(full.world.holder.compliance()),
      clearance(full.world.annulus.clearance()) {
  const World& world = full.world;
  for (std::uint64_t k = 0; k < probes_of(full); ++k) {
    probes.push_back(make_probe(full, k));
    const Probe& p = probes.back();
    std::size_t sample = 0;
    runs.push_back(sample_run(world, p.start, p.hand, full.limits.force,
                              [&](const State& s, const Breakdown& b) {
                                const auto forces = term_forces(b);
                                for (std::size_t i = 0; i < kTerms; ++i)
                                  if (forces[i].norm() > most[i]) {
                                    most[i] = forces[i].norm();
                                    where[i] = s;
                                  }
                                if (s.tip[0] < 0 && ++sample % kEveryForFidelity == 0)
                                  inside.push_back(s);
                              }));
    force_scale = std::min(force_scale, largest_force(runs.back()));
    sticks = sticks || snaps(runs.back(), p.hand, clearance);
  }
  sticks = sticks || most[kFrictionTerm] > 0 || world.drag;  // drag slows a snap down and hides it
  force_scale = std::max(force_scale, clearance / compliance);
}

double Reference::error(const World& reduced, double enough) const {
  double worst = 0;
  for (std::size_t k = 0; k < probes.size() && worst <= enough; ++k) {
    const Probe& p = probes[k];
    const SampledRun r = sample_run(reduced, p.start, p.hand, INFINITY);
    worst = std::max(worst, run_error(r, runs[k], p.hand, scene.world));
  }
  return worst;
}

// Terms that may be left out together, and what that changes at most.
struct LeftOut {
  std::vector<int> terms;
  double change = 0;
};

LeftOut smallest_terms(const Reference& reference, double enough) {
  const auto most = [&](int i) { return reference.most[static_cast<std::size_t>(i)]; };
  std::vector<int> order;
  for (int i = 0; i < kTerms; ++i)  // one that was not seen may act elsewhere
    if (has_term(reference.scene.world, i) && i != kWallTerm && most(i) > 0) order.push_back(i);
  std::sort(order.begin(), order.end(),
            [&](int a, int b) { return std::pair(most(a), a) < std::pair(most(b), b); });
  LeftOut out;
  for (const int i : order) {
    const double more = reference.changes(most(i));
    if (out.change + more > enough) break;
    out.change += more;
    out.terms.push_back(i);
  }
  return out;
}

struct Fidelity {
  bool closed_form;
  int nodes;
};
// The cheapest first; the last is the full model's.
constexpr std::array<Fidelity, 7> kFidelities = {
    {{false, 1}, {true, 1}, {true, 2}, {true, 3}, {true, 5}, {true, 8}, {true, kFullNodes}}};

// A model to choose.
struct Reduced {
  std::vector<int> without;
  Fidelity fidelity;
  Dynamics dynamics;
  double step;  // longest [s]
};

Scene reduced_scene(const Scene& full, const Reduced& r) {
  return changed(full, [&](Json& d) {
    for (const int i : r.without) d["laws"][kTermNames[static_cast<std::size_t>(i)]] = nullptr;
    d["quadrature"] = r.fidelity.nodes;
    if (!r.fidelity.closed_form) d["tilted_axes"] = "quadrature";
    d["dynamics"] = r.dynamics == Dynamics::inertial ? "inertial" : "quasi_static";
    if (r.dynamics == Dynamics::quasi_static) d.erase("integrator");
    d["step_s"] = r.step;
  });
}

// The chosen model, with what it leaves out, coarsens and steps over.
struct Choice {
  Reduced model;
  LeftOut left_out;
  std::array<double, kSurfaceTerms> coarser{};  // largest errors of the fidelity [N]
  double error;  // largest that is to be expected: that measured over the share it may have
};

// The cheapest fidelity of surface forces that is good enough, and its errors.
Fidelity choose_fidelity(const Reference& reference, const std::vector<int>& without, double enough,
                         std::array<double, kSurfaceTerms>& coarser) {
  const auto world = [&](Fidelity f) {
    return reduced_scene(reference.scene,
                         {without, f, reference.scene.world.dynamics, kSamplePeriod})
        .world;
  };
  const World finest = world(kFidelities.back());
  for (const Fidelity& f : kFidelities) {
    coarser = fidelity_error(world(f), finest, reference.inside);
    if (reference.changes(coarser[0] + coarser[1] + coarser[2]) <= enough) return f;
  }
  return kFidelities.back();
}

// What may be spent, of the tolerance, and which steps there are to choose from.
struct Room {
  double tolerance;                  // for all but inertia that is left out unmeasured
  bool try_quasi_static;             // in place of the full model's inertia
  const std::vector<double>& steps;  // [s], the last is the full model's
};

// What is left out where that is good enough, else with every term; then the longest step.
Choice choose(const Reference& reference, const Room& room) {
  const World& world = reference.scene.world;
  const double measured = world.drag ? kMeasuredWithDrag : kMeasured;
  const double enough = measured * room.tolerance;
  const auto share = [&](double part) {
    return (reference.sticks ? kShareWhereItSticks : part) * room.tolerance;
  };
  const Choice full{{{}, kFidelities.back(), world.dynamics, room.steps.back()}, {}, {}, INFINITY};

  // How wrong the full model's own step is, the next longer one tells. Where that is too much, no
  // step of the list is fine enough to leave anything out beside it.
  double full_error = 0;
  if (room.steps.size() > 1) {
    Reduced longer = full.model;
    longer.step = room.steps[room.steps.size() - 2];
    full_error = reference.error(reduced_scene(reference.scene, longer).world, INFINITY);
  }
  Choice nothing_reduced = full;
  nothing_reduced.error = full_error / measured;
  if (full_error > enough) return nothing_reduced;

  std::vector<LeftOut> tries = {smallest_terms(reference, share(kShare))};
  if (!tries.front().terms.empty()) tries.emplace_back();
  for (const LeftOut& left_out : tries) {
    Choice c = full;
    c.left_out = left_out;
    c.model.without = left_out.terms;
    c.model.fidelity =
        choose_fidelity(reference, left_out.terms, share(kShareOfFidelity), c.coarser);
    std::vector<std::pair<Dynamics, double>> ways;
    if (room.try_quasi_static) ways.emplace_back(Dynamics::quasi_static, room.steps.front());
    for (const double step : room.steps) ways.emplace_back(world.dynamics, step);
    for (const auto& [dynamics, step] : ways) {
      c.model.dynamics = dynamics;
      c.model.step = step;
      c.error = reference.error(reduced_scene(reference.scene, c.model).world, enough);
      if (c.error > enough) continue;
      if (step == room.steps.back()) c.error = std::max(c.error, full_error);
      c.error /= measured;
      return c;
    }
  }
  return nothing_reduced;
}

std::vector<PlannedTerm> planned_terms(const Reference& reference, const Choice& choice,
                                       const World& chosen) {
  std::vector<PlannedTerm> terms;
  for (int i = 0; i < kTerms; ++i) {
    if (!has_term(reference.scene.world, i)) continue;
    const auto at = static_cast<std::size_t>(i);
    const std::vector<int>& without = choice.left_out.terms;
    PlannedTerm term;
    term.name = kTermNames[at];
    term.kept = std::find(without.begin(), without.end(), i) == without.end();
    term.fidelity = term.kept ? fidelity(chosen, i) : "none";
    term.max_force = reference.most[at];
    term.state = reference.where[at];
    term.relative_error = 0;
    if (!term.kept)
      term.relative_error = reference.changes(term.max_force);
    else if ((i == 0 || i == 1 || i == 3) && term.max_force > 0)
      term.relative_error =
          choice.coarser[i == 3 ? kCapillary : static_cast<SurfaceTerm>(i)] / term.max_force;
    if (term.kept && i == 1 && electrostatic_in_closed_form(chosen))
      term.relative_error += closed_form_error(chosen.annulus);
    terms.push_back(term);
  }
  return terms;
}

}  // namespace

Plan make_plan(const Scene& scene, double tolerance) {
  if (!(tolerance >= 1e-6 && tolerance <= 0.5))
    throw BadInput("accuracy = " + Json(tolerance).dump() + ": must be from 1e-6 to 0.5");

  // Inertia, where the scene does not say: the force that speeds the fibre up.
  const bool stated = scene.document.contains("dynamics");
  const Holder& holder = scene.world.holder;
  const double mass = holder.mass.topLeftCorner<3, 3>().norm();
  const double inertia = mass * kPeakOfMinimumJerk * scene.limits.speed / kSpeedingUp;
  const double slow =  // what leaving it out changes
      inertia * holder.compliance() / scene.world.annulus.clearance();
  const bool rings = !stated && slow > kShareOfInertia * tolerance;
  const bool inertial = rings || scene.world.dynamics == Dynamics::inertial;
  const std::vector<double>& steps = inertial           ? kInertialSteps
                                     : scene.world.drag ? kDragSteps
                                                        : kTimeless;
  const Scene full = changed(scene, [&](Json& d) {
    d.erase("accuracy");
    d.erase("tilted_axes");
    d["quadrature"] = kFullNodes;
    if (rings) d["dynamics"] = "inertial";
    if (inertial) d["integrator"] = "bdf2";
    d["step_s"] = steps.back();
  });

  const Reference reference(full);
  const double room = stated || rings ? tolerance : tolerance - slow;
  const Choice choice = choose(reference, {room, inertial && stated, steps});
  const Scene chosen = reduced_scene(full, choice.model);

  Plan plan;
  plan.tolerance = tolerance;
  plan.dynamics = choice.model.dynamics;
  plan.step = choice.model.step;
  plan.force_scale = reference.force_scale;
  plan.error_bound =
      std::max(choice.error,
               choice.left_out.change +
                   reference.changes(choice.coarser[0] + choice.coarser[1] + choice.coarser[2]));
  plan.terms = planned_terms(reference, choice, chosen.world);
  if (!stated || inertial) {
    // Where the scene has it, what leaving it out changes is measured.
    const bool kept = plan.dynamics == Dynamics::inertial;
    const double change = kept ? 0 : stated ? choice.error : slow;
    plan.terms.push_back(
        {"inertia", kept, kept ? "second order (BDF2)" : "none", inertia, change, State()});
    if (!stated) plan.error_bound += change;
  }
  plan.document = chosen.document;
  plan.document["planned_accuracy"] = tolerance;
  plan.document["planned_error_bound"] = plan.error_bound;
  return plan;
}

}  // namespace ferrule
