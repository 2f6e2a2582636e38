#include "sim/plan.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "sim/fidelity.hpp"
#include "sim/minimum_jerk.hpp"
#include "sim/probe.hpp"
#include "sim/sampled_run.hpp"
#include "sim/tilted_annulus.hpp"

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
constexpr double kShareOfInertia = 0.8;  // which it may change where it is left out unmeasured
constexpr double kMeasured = 0.3;        // of the tolerance that the chosen model may miss by

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

}  // namespace

Plan make_plan(const Scene& scene, double tolerance) {
  if (!(tolerance >= 1e-6 && tolerance <= 0.5))
    throw BadInput("accuracy = " + Json(tolerance).dump() + ": must be from 1e-6 to 0.5");
  const double c = scene.world.annulus.clearance();
  const bool stated = scene.document.contains("dynamics");

  // Inertia, where the scene does not say: the force that speeds the fibre up.
  const double mass = scene.world.holder.mass.topLeftCorner<3, 3>().norm();
  const double soft = scene.world.holder.compliance();
  const double inertia = mass * kPeakOfMinimumJerk * scene.limits.speed / kSpeedingUp;
  const double slow = inertia * soft / c;  // what leaving it out changes
  const bool rings = !stated && slow > kShareOfInertia * tolerance;
  const double room = stated || rings ? tolerance : tolerance - slow;  // for all else
  const bool to_be_inertial = rings || scene.world.dynamics == Dynamics::inertial;
  const std::vector<double>& steps = to_be_inertial     ? kInertialSteps
                                     : scene.world.drag ? kDragSteps
                                                        : kTimeless;
  const Scene full = changed(scene, [&](Json& d) {
    d.erase("accuracy");
    d.erase("tilted_axes");
    d["quadrature"] = kFullNodes;
    if (rings) d["dynamics"] = "inertial";
    if (to_be_inertial) d["integrator"] = "bdf2";
    d["step_s"] = steps.back();
  });
  const World& world = full.world;
  const bool inertial = world.dynamics == Dynamics::inertial;

  // The full model along the probes.
  std::vector<Probe> probes;
  std::vector<SampledRun> exact;  // of each probe
  std::vector<State> states;
  std::array<double, kTerms> most{};
  std::array<State, kTerms> where;
  double force_scale = INFINITY;
  bool sticks = false;  // or snaps
  for (std::uint64_t k = 0; k < probes_of(full); ++k) {
    probes.push_back(make_probe(full, k));
    const Probe& p = probes.back();
    std::size_t sample = 0;
    exact.push_back(sample_run(world, p.start, p.hand, scene.limits.force,
                               [&](const State& s, const Breakdown& b) {
                                 const auto forces = term_forces(b);
                                 for (std::size_t i = 0; i < kTerms; ++i)
                                   if (forces[i].norm() > most[i]) {
                                     most[i] = forces[i].norm();
                                     where[i] = s;
                                   }
                                 if (s.tip[0] < 0 && ++sample % kEveryForFidelity == 0)
                                   states.push_back(s);
                               }));
    force_scale = std::min(force_scale, largest_force(exact.back()));
    sticks = sticks || snaps(exact.back(), p.hand, c);
  }
  sticks = sticks || most[kFrictionTerm] > 0 || world.drag;  // drag slows a snap down and hides it
  force_scale = std::max(force_scale, c / soft);
  // What a force that is missing can change: the felt force, and where the end is.
  const auto changes = [&](double force) { return force * std::max(1 / force_scale, soft / c); };

  // What to leave out: the smallest terms, as long as all of them together are small enough.
  std::vector<int> order;
  for (int i = 0; i < kTerms; ++i)
    if (has_term(world, i) && i != kWallTerm) order.push_back(i);
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    return std::pair(most[static_cast<std::size_t>(a)], a) <
           std::pair(most[static_cast<std::size_t>(b)], b);
  });
  std::vector<int> left_out;
  double spent = 0;
  for (const int i : order) {
    if (most[static_cast<std::size_t>(i)] == 0) continue;  // not seen: it may act elsewhere
    const double more = changes(most[static_cast<std::size_t>(i)]);
    if (spent + more > (sticks ? kShareWhereItSticks : kShare) * room) break;
    spent += more;
    left_out.push_back(i);
  }

  // The cheapest fidelity that is good enough, then the longest step, all of it measured.
  struct Fidelity {
    bool closed_form;
    int nodes;
  };
  std::vector<Fidelity> fidelities = {{false, 1}};
  for (const int nodes : {1, 2, 3, 5, 8, kFullNodes}) fidelities.push_back({true, nodes});
  const auto candidate = [&](const std::vector<int>& without, Fidelity f, Dynamics dynamics,
                             double longest_step) {
    return changed(full, [&](Json& d) {
      for (const int i : without) d["laws"][kTermNames[static_cast<std::size_t>(i)]] = nullptr;
      d["quadrature"] = f.nodes;
      if (!f.closed_form) d["tilted_axes"] = "quadrature";
      d["dynamics"] = dynamics == Dynamics::inertial ? "inertial" : "quasi_static";
      if (dynamics == Dynamics::quasi_static && !scene.document.contains("integrator"))
        d.erase("integrator");
      d["step_s"] = longest_step;
    });
  };
  // The largest error in any probe, or the first beyond `enough`.
  const auto measured = [&](const World& reduced, double enough) {
    double worst = 0;
    for (std::size_t k = 0; k < probes.size() && worst <= enough; ++k) {
      const Probe& p = probes[k];
      const SampledRun r = sample_run(reduced, p.start, p.hand, INFINITY);
      worst = std::max(worst, run_error(r, exact[k], p.hand, world));
    }
    return worst;
  };

  // How wrong the full model's own step is, the next longer one tells. Where that is too much, no
  // step of the list is fine enough to leave anything out beside it.
  double full_error = 0;
  if (steps.size() > 1)
    full_error = measured(
        candidate({}, fidelities.back(), world.dynamics, steps[steps.size() - 2]).world, INFINITY);
  const bool fine_enough = full_error <= kMeasured * room;

  std::array<double, kSurfaceTerms> wrong{};
  const auto choose_fidelity = [&](const std::vector<int>& without) {
    for (const Fidelity& f : fidelities) {
      wrong =
          fidelity_error(candidate(without, f, world.dynamics, 1e-3).world,
                         candidate(without, fidelities.back(), world.dynamics, 1e-3).world, states);
      if (changes(wrong[0] + wrong[1] + wrong[2]) <=
          (sticks ? kShareWhereItSticks : kShareOfFidelity) * room)
        return f;
    }
    return fidelities.back();
  };

  Plan plan;
  Scene chosen = full;
  bool found = false;
  double error = INFINITY;
  for (const bool everything : {false, true}) {
    if (!fine_enough || (everything && left_out.empty())) continue;
    const std::vector<int> without = everything ? std::vector<int>{} : left_out;
    const Fidelity f = choose_fidelity(without);
    std::vector<std::pair<Dynamics, double>> ways;
    if (inertial && stated) ways.emplace_back(Dynamics::quasi_static, kInertialSteps.front());
    for (const double h : steps) ways.emplace_back(world.dynamics, h);
    for (const auto& [dynamics, longest] : ways) {
      chosen = candidate(without, f, dynamics, longest);
      error = measured(chosen.world, kMeasured * room);
      found = error <= kMeasured * room;
      if (found) break;
    }
    if (found) {
      if (everything) spent = 0, left_out.clear();
      break;
    }
  }
  if (!found) {
    left_out.clear();
    spent = error = 0;
    wrong = {};
    chosen = full;
  }

  if (chosen.world.longest_step == steps.back()) error = std::max(error, full_error);

  plan.tolerance = tolerance;
  plan.dynamics = chosen.world.dynamics;
  plan.step = chosen.world.longest_step;
  plan.force_scale = force_scale;
  plan.error_bound = std::max(error, spent + changes(wrong[0] + wrong[1] + wrong[2]));
  for (int i = 0; i < kTerms; ++i) {
    if (!has_term(world, i)) continue;
    const auto at = static_cast<std::size_t>(i);
    PlannedTerm term;
    term.name = kTermNames[at];
    term.kept = std::find(left_out.begin(), left_out.end(), i) == left_out.end();
    term.fidelity = term.kept ? fidelity(chosen.world, i) : "none";
    term.max_force = most[at];
    term.state = where[at];
    term.relative_error = 0;
    if (!term.kept)
      term.relative_error = changes(most[at]);
    else if (i == 0 || i == 1 || i == 3)
      term.relative_error =
          most[at] > 0 ? wrong[i == 3 ? kCapillary : static_cast<SurfaceTerm>(i)] / most[at] : 0;
    if (term.kept && i == 1 && electrostatic_in_closed_form(chosen.world))
      term.relative_error += closed_form_error(chosen.world.annulus);
    plan.terms.push_back(term);
  }
  if (!stated || inertial) {
    // Where the scene has it, what leaving it out changes is measured.
    const bool kept = plan.dynamics == Dynamics::inertial;
    const double change = kept ? 0 : stated ? error : slow;
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
