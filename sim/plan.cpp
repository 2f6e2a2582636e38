#include "sim/plan.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "sim/insertion.hpp"
#include "sim/minimum_jerk.hpp"
#include "sim/random.hpp"
#include "sim/surface_forces.hpp"
#include "sim/tilted_annulus.hpp"

namespace ferrule {
namespace {

// Places in kTermNames.
constexpr int kWallTerm = 5, kFrictionTerm = 6;

constexpr std::uint64_t kProbeSeed = 20;
constexpr std::uint64_t kProbes = 8;
constexpr int kFullNodes = 16;                          // of the quadrature of the full model
constexpr double kSample = 1e-3;                        // [s]
constexpr double kLongest = 16, kLongestWithDrag = 30;  // of a probe [s]
// Of a probe [m].
constexpr double kDeepest = 100e-6, kDeepestWithDrag = 20e-6, kDeepestInertial = 5e-6;
constexpr double kMostLean = 0.03;            // [rad]
constexpr double kSpeedingUp = 0.1;           // time in which a hand changes its speed [s]
constexpr std::size_t kEveryForFidelity = 7;  // samples at which fidelities are compared

// Steps to choose from [s]; the last is the full model's. Without drag and inertia nothing depends
// on time, and the control period is the step. A system with inertia rings: it is stepped much
// finer, along shorter probes.
const std::vector<double> kTimeless = {1e-3};
const std::vector<double> kDragSteps = {1e-3, 5e-4, 2.5e-4, 1e-4, 5e-5};
const std::vector<double> kInertialSteps = {1e-3, 1e-4, 2e-5, 1e-5, 5e-6};
constexpr std::uint64_t kInertialProbes = 2;
constexpr double kInertialLongest = 2;  // [s]

constexpr double kShare = 0.2;  // of the tolerance that all that is left out may take
constexpr double kShareWhereItSticks = 1e-4;
constexpr double kShareOfFidelity = 0.2;
constexpr double kMeasured = 0.3;  // of the tolerance that the chosen model may miss by

// Hand poses of a probe, one per millisecond: to the mouth, in, pushes in two directions with a
// tilt, half way out while pressed, and out.
std::vector<Pose> probe(const Scene& scene, const State& start, std::uint64_t k) {
  RandomStream random(kProbeSeed, k, Draw::plan);
  const World& world = scene.world;
  const double deepest = world.dynamics == Dynamics::inertial ? kDeepestInertial
                         : world.drag                         ? kDeepestWithDrag
                                                              : kDeepest;
  const double c = world.annulus.clearance(), depth = std::min(scene.success.depth, deepest);
  const auto around = [&](double scale) { return scale * (2 * random.uniform() - 1); };
  const double push =
      c + 0.7 * scene.limits.force / world.holder.stiffness.block<2, 2>(1, 1).norm();
  // Half of them lean as the scene's starts do, half as much as the bore allows.
  const double lean = std::min(k % 2 ? scene.start.tilt_sd : kMostLean, c / depth);

  std::vector<Pose> tips = {start.tip};
  const auto next = [&](double x, double y, double z, double ty, double tz) {
    Pose p;
    p << x, y, z, ty, tz;
    tips.push_back(p);
  };
  const double outside = world.profile.lead_in_length + 2e-6, mouth = 2e-6;
  const Vector2d aside(around(0.6 * c), around(0.6 * c));
  const double ty = around(lean), tz = around(lean);
  const bool misaligned = k % 4 == 3;  // straight down from where it is
  if (misaligned) {
    next(-depth, start.tip[1], start.tip[2], start.tip[3], start.tip[4]);
  } else {
    tips.front() << mouth, aside, ty, tz;
    next(-depth, aside.x(), aside.y(), ty, tz);
  }
  for (const double side : {1.0, -1.0}) {
    const double angle = std::numbers::pi * random.uniform();
    const double y = side * push * std::cos(angle), z = side * push * std::sin(angle);
    next(-depth, y, z, ty + around(lean), tz + around(lean));
    next(-(0.4 + 0.2 * random.uniform()) * depth, y, z, ty, tz);
  }
  next(misaligned ? outside : mouth, aside.x(), aside.y(), 0, 0);

  const double lever = depth + world.annulus.fibre_radius;
  const auto way_to = [&](std::size_t i) {
    const Pose move = tips[i] - tips[i - 1];
    return move.head<3>().norm() + lever * move.tail<2>().norm();
  };
  // Where nothing depends on time the hand may as well be faster than the scene's.
  double speed = scene.limits.speed, all = 0;
  for (std::size_t i = 1; i < tips.size(); ++i) all += way_to(i);
  if (!world.drag && world.dynamics == Dynamics::quasi_static)
    speed = std::max(speed, kPeakOfMinimumJerk * all / (0.75 * kLongest));
  std::vector<Pose> hand = {tips.front() - world.holder.sag};
  const double longest = world.dynamics == Dynamics::inertial ? kInertialLongest
                         : world.drag                         ? kLongestWithDrag
                                                              : kLongest;
  for (std::size_t i = 1; i < tips.size(); ++i) {
    const Pose from = hand.back(), to = tips[i] - world.holder.sag;
    const double part = speed * (0.5 + 0.5 * random.uniform());
    const auto steps = static_cast<std::size_t>(
        std::ceil(std::max(kPeakOfMinimumJerk * way_to(i) / part, 2 * kSpeedingUp) / kSample));
    for (std::size_t n = 1; n <= steps; ++n) {
      if (static_cast<double>(hand.size()) * kSample > longest) return hand;
      const double p = static_cast<double>(n) / static_cast<double>(steps);
      hand.push_back(from + minimum_jerk(p) * (to - from));
    }
  }
  return hand;
}

using Watch = std::function<void(const State&, const Breakdown&)>;

SampledRun run(const World& world, const State& start, const std::vector<Pose>& hand,
               double force_limit, const Watch& watch) {
  SampledRun samples;
  State state = start;
  for (const Pose& pose : hand) {
    const StepResult r = step(world, state, pose, samples.tip.empty() ? 0.0 : kSample);
    state = r.state;
    samples.tip.push_back(state.tip.head<3>());
    samples.force.push_back(r.forces.holder.head<3>());
    if (watch) watch(state, r.forces);
    if (!(holder_force(world, r.forces).norm() <= force_limit)) break;
  }
  return samples;
}

double largest_force(const SampledRun& run) {
  double largest = 0;
  for (const Vector3d& f : run.force) largest = std::max(largest, f.norm());
  return largest;
}

// Does the end move by far more than the hand does?
bool snaps(const SampledRun& run, const std::vector<Pose>& hand, double clearance) {
  for (std::size_t n = 1; n < run.tip.size(); ++n) {
    const double moved = (run.tip[n] - run.tip[n - 1]).norm();
    if (moved > 5 * (hand[n] - hand[n - 1]).head<3>().norm() + 0.01 * clearance) return true;
  }
  return false;
}

Scene changed(const Scene& scene, const std::function<void(Json&)>& change) {
  Json document = scene.document;
  change(document);
  return parse_scene(document, scene.name);
}

std::string fidelity(const World& world, int term) {
  const auto nodes = [&] {
    return world.quadrature.order == 1
               ? std::string("annulus, parallel axes")
               : "tilted quadrature of order " + std::to_string(world.quadrature.order);
  };
  const auto printed = [](const auto& law) { return law->form == Form::printed; };
  switch (term) {
    case 0:
      if (printed(world.van_der_waals)) return "patch";
      return world.closed_form ? "tilted annulus closed form" : nodes();
    case 1:
      if (printed(world.electrostatic)) return "patch";
      return electrostatic_in_closed_form(world) ? "tilted annulus closed form"
                                                 : "exact cylinders, " + nodes();
    case 2:
      return "weight";
    case 3:
      return printed(world.capillary) ? "patch" : "bridge, " + nodes();
    case 4:
      return printed(world.adhesion) ? "prescribed radius" : "Maugis table";
    case 5:
      return "Hertz";
    case 6:
      return "Hurtado-Kim, stuck spring";
    case 7:
      return "Couette and short bearing";
    default:
      return "closed form";
  }
}

bool has_term(const World& w, int term) {
  const std::array<bool, kTerms> there = {
      w.van_der_waals.has_value(), w.electrostatic.has_value(), w.gravity.has_value(),
      w.capillary.has_value(),     w.adhesion.has_value(),      w.wall.has_value(),
      w.friction.has_value(),      w.drag.has_value(),          w.meniscus.has_value()};
  return there[static_cast<std::size_t>(term)];
}

// Largest force in a surface term that `coarse` gets wrong at these poses, by term [N].
std::array<double, kSurfaceTerms> fidelity_error(const World& coarse, const World& full,
                                                 const std::vector<State>& states) {
  std::array<double, kSurfaceTerms> worst{};
  for (const State& s : states) {
    std::array<SurfaceGradients, 2> terms;
    Energy energy;
    add_surface_forces(energy, terms[0], coarse, s.inserted_length(), s.bridge, s.tip);
    add_surface_forces(energy, terms[1], full, s.inserted_length(), s.bridge, s.tip);
    for (std::size_t i = 0; i < kSurfaceTerms; ++i) {
      const PoseVector &a = terms[0][i], &b = terms[1][i];
      // A wrong moment counts as a wrong force at the lever of the inserted length.
      const double lever = s.inserted_length() + coarse.annulus.fibre_radius;
      worst[i] = std::max(worst[i], PoseVector(a.x - b.x, a.e - b.e, a.t - b.t).length() +
                                        (a.t - b.t).norm() / lever);
    }
  }
  return worst;
}

// How far a newton may move the end, holder alone [m/N].
double compliance(const Holder& holder) {
  return Matrix5(holder.stiffness.inverse()).topLeftCorner<3, 3>().norm();
}

}  // namespace

SampledRun sample_run(const World& world, const State& start, const std::vector<Pose>& hand,
                      double force_limit) {
  return run(world, start, hand, force_limit, nullptr);
}

double run_error(const SampledRun& run, const SampledRun& full, const std::vector<Pose>& hand,
                 const World& world) {
  const std::size_t count = std::min(run.tip.size(), full.tip.size());
  const double clearance = world.annulus.clearance();
  const double scale = std::max(largest_force(full), clearance / compliance(world.holder));
  double worst = 0;
  for (std::size_t n = 0; n < count; ++n) {
    double best = INFINITY;
    const auto compare = [&](std::size_t m, double travel) {
      const double tip = (run.tip[n] - full.tip[m]).norm() / clearance;
      const double force = (run.force[n] - full.force[m]).norm() / scale;
      best = std::min(best, std::max({tip, force, travel}));
    };
    compare(n, 0);
    for (const int way : {-1, 1})
      for (std::size_t k = 1; best > worst && k < count; ++k) {
        if (way < 0 ? k > n : n + k >= count) break;
        const std::size_t m = way < 0 ? n - k : n + k;
        const double travel = (hand[m] - hand[n]).head<3>().norm() / clearance;
        if (k > 1 && travel >= best) break;
        compare(m, k == 1 ? 0 : travel);
      }
    worst = std::max(worst, best);
  }
  return worst;
}

Plan make_plan(const Scene& scene, double tolerance) {
  if (!(tolerance >= 1e-6 && tolerance <= 0.5))
    throw BadInput("accuracy = " + Json(tolerance).dump() + ": must be from 1e-6 to 0.5");
  const double c = scene.world.annulus.clearance();
  const bool stated = scene.document.contains("dynamics");

  // Inertia, where the scene does not say: the force that speeds the fibre up.
  const double mass = scene.world.holder.mass.topLeftCorner<3, 3>().norm();
  const double soft = compliance(scene.world.holder);
  const double inertia = mass * kPeakOfMinimumJerk * scene.limits.speed / kSpeedingUp;
  const bool rings = !stated && inertia * soft / c > tolerance;
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
  struct Probe {
    State start;
    std::vector<Pose> hand;
    SampledRun samples;
  };
  std::vector<Probe> probes;
  std::vector<State> states;
  std::array<double, kTerms> most{};
  std::array<State, kTerms> where;
  double force_scale = INFINITY;
  bool sticks = false;  // or snaps
  for (std::uint64_t k = 0; k < (inertial ? kInertialProbes : kProbes); ++k) {
    Probe p;
    p.start = draw_start(full, kProbeSeed, k);
    // Free flight tells nothing.
    Pose from = p.start.tip;
    from[0] = std::min(from[0], world.profile.lead_in_length + 5e-6);
    p.start = at_rest(world, from);
    p.hand = probe(full, p.start, k);
    p.start = at_rest(world, p.hand.front() + world.holder.sag);
    std::size_t sample = 0;
    p.samples =
        run(world, p.start, p.hand, scene.limits.force, [&](const State& s, const Breakdown& b) {
          const auto forces = term_forces(b);
          for (std::size_t i = 0; i < kTerms; ++i)
            if (forces[i].norm() > most[i]) {
              most[i] = forces[i].norm();
              where[i] = s;
            }
          if (s.tip[0] < 0 && ++sample % kEveryForFidelity == 0) states.push_back(s);
        });
    force_scale = std::min(force_scale, largest_force(p.samples));
    sticks = sticks || snaps(p.samples, p.hand, c);
    probes.push_back(std::move(p));
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
    if (spent + more > (sticks ? kShareWhereItSticks : kShare) * tolerance) break;
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
  const auto measured = [&](const Scene& reduced) {
    double worst = 0;
    for (const Probe& p : probes) {
      const SampledRun r = sample_run(reduced.world, p.start, p.hand, INFINITY);
      worst = std::max(worst, run_error(r, p.samples, p.hand, world));
      if (worst > kMeasured * tolerance) break;
    }
    return worst;
  };

  std::array<double, kSurfaceTerms> wrong{};
  const auto choose_fidelity = [&](const std::vector<int>& without) {
    for (const Fidelity& f : fidelities) {
      wrong =
          fidelity_error(candidate(without, f, world.dynamics, 1e-3).world,
                         candidate(without, fidelities.back(), world.dynamics, 1e-3).world, states);
      if (changes(wrong[0] + wrong[1] + wrong[2]) <=
          (sticks ? kShareWhereItSticks : kShareOfFidelity) * tolerance)
        return f;
    }
    return fidelities.back();
  };

  Plan plan;
  Scene chosen = full;
  bool found = false;
  double error = INFINITY;
  for (const bool everything : {false, true}) {
    if (everything && left_out.empty()) continue;
    const std::vector<int> without = everything ? std::vector<int>{} : left_out;
    const Fidelity f = choose_fidelity(without);
    std::vector<std::pair<Dynamics, double>> ways;
    if (inertial && stated) ways.emplace_back(Dynamics::quasi_static, kInertialSteps.front());
    for (const double h : steps) ways.emplace_back(world.dynamics, h);
    for (const auto& [dynamics, longest] : ways) {
      chosen = candidate(without, f, dynamics, longest);
      error = measured(chosen);
      found = error <= kMeasured * tolerance;
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

  // How wrong the full model's own step is, the next longer one tells.
  if (chosen.world.longest_step == steps.back() && steps.size() > 1) {
    const World coarser =
        candidate(left_out, fidelities.back(), world.dynamics, steps[steps.size() - 2]).world;
    for (const Probe& p : probes)
      error = std::max(error, run_error(sample_run(coarser, p.start, p.hand, INFINITY), p.samples,
                                        p.hand, world));
  }
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
  const bool keeps_inertia = plan.dynamics == Dynamics::inertial;
  plan.terms.push_back({"inertia", keeps_inertia, keeps_inertia ? "second order (BDF2)" : "none",
                        inertia, keeps_inertia ? 0 : changes(inertia), State()});
  if (!keeps_inertia && !stated) plan.error_bound = std::max(plan.error_bound, changes(inertia));
  plan.document = chosen.document;
  plan.document["planned_accuracy"] = tolerance;
  plan.document["planned_error_bound"] = plan.error_bound;
  return plan;
}

}  // namespace ferrule
