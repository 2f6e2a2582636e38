// What of a scene may be left out for a tolerance, and by how much the result then changes:
// measured against the full model, every term of the scene in the finest fidelity, along the same
// probe motions.
//
// A plan is for starts of the scene's start distribution and for commands at 1 kHz that move at up
// to limits.speed and change speed in 0.1 s: insertion to the success depth, sideways pushes,
// tilting and withdrawal, as long as the force at the holder stays below limits.force. Errors are
// those of sim/analysis/sampled_run.hpp. Parts with a tolerance have their nominal diameters.
//
// A term is left out where the largest force it has in any probe could not change the result by a
// fifth of the tolerance; for a motion, where the fibre snaps, sticks by friction or is dragged, by
// 1e-4 of it, since there small forces decide where it comes to rest. What is left is then run. The
// bound is three times the largest error of all probes, since other motions differ by more; with
// drag it is twenty times as large, since the fibre moves the faster the less of it the liquid
// still holds. Where leaving out is not good enough, all terms stay.
//
// For a motion, steps in time and the following of smooth intervals along the tangent
// (sim/solver/extrapolation.hpp) are the scene's own. Without drag, flow and inertia nothing
// depends on time, and the full model has them too. With drag or flow it takes steps an eighth as
// long, with inertia also no longer than 5 us. With drag, friction or adhesion no step ends at the
// same place after a snap: there steps are judged in between, along intervals of 0.1 s against
// eight times finer ones from the same state, by the error that 95 % of the intervals stay below.
//
// A success rate bears more: a hand that is off by a thousandth of the clearance ends elsewhere by
// a tenth of it, and as many of scattered starts come in. A plan for it asks only that a control
// period is what the full model, every step solved, would make of it from the same state, in 95 %
// of the periods of four probes. Of following the tangent to 0.3 or 0.03 of the tolerance, without
// the small terms or with all, it takes the first that is good enough. Scenes with inertia are
// planned for the motion.
//
// Where a scene does not say which dynamics it has, it gets inertia if leaving that out changes
// more than 0.8 of the tolerance: by the acceleration of the command and, where the scene states
// how the fibre is damped (holder.loss_factor, eta), by how far the hand goes at limits.speed, over
// the clearance, until a snap of a clearance has rung down to the tolerance,
//   t = 2 log(1/tolerance)/(eta omega_1).
// Without damping the bound does not cover how a fibre rings after a snap.
//
// Where the fibre snaps or sticks, the same command sampled and stepped twice as finely ends
// elsewhere. By how much is measured too; it counts in the bound of a motion where a scene asks
// for events coarser than 1 nm.
#pragma once

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "sim/scene/scene.hpp"

namespace ferrule {

enum class PlanFor { motion, success };

struct PlannedTerm {
  std::string name;  // as in the table of terms, "curl" or "inertia"
  bool kept;
  std::string fidelity;   // how it is computed; "none" where left out
  double max_force;       // largest in any probe [N]
  double relative_error;  // of its closed form where kept; what leaving it out changes at most else
  State state;            // where it was largest: what a benchmark of its cost evaluates
};

struct Plan {  // NOLINT(bugprone-exception-escape): the JSON library moves without one
  double tolerance;
  // Those of the scene, in the order of the table of terms, then curl, if it has it, and inertia,
  // unless the scene says that it is quasi-static.
  std::vector<PlannedTerm> terms;
  Dynamics dynamics;
  double step;  // longest in time [s]
  // Error to which smooth intervals follow the tangent, of the clearance [-]; 0: none does.
  double tangent = 0;
  double force_scale;      // what force errors are relative to [N]
  double error_bound = 0;  // of tip over clearance and of force over force_scale
  // By how much the same motions, sampled twice as finely and taken in steps half as long, each of
  // them solved, end elsewhere in the full model, in the same measure; whether that counts in the
  // bound, events not being located.
  double sampled_twice = 0;
  bool sampling_counts = false;
  double step_error = 0;  // what of the bound its steps are, and all that is chosen with them [-]
  // How long a snap of a clearance rings until it is within the tolerance [s]; infinite where the
  // scene states no damping.
  double rings = INFINITY;
  Json document;  // the planned scene
  // It was stopped: nothing is left out, the error bound is infinite, the largest forces are those
  // of the probes that were run.
  bool partial = false;
};

// Called between the runs of a plan, with those that are done and those that may be needed. False
// stops it.
using PlanProgress = std::function<bool(std::size_t runs, std::size_t most)>;

// Whatever accuracy the scene itself asks for; 1e-6 <= tolerance <= 0.5. Deterministic; takes about
// a second. Throws BadInput if the tolerance is out of range.
Plan make_plan(const Scene& scene, double tolerance, const PlanProgress& go_on = {},
               PlanFor quantity = PlanFor::motion);

// The scene itself, or where it states an accuracy the planned one. Throws BadInput, and what
// `go_on` throws.
Scene planned(const Scene& scene, const PlanProgress& go_on = {});

}  // namespace ferrule
