// Which terms, dynamics and step a scene needs for a tolerance: both speed and accuracy,
// by measurement. The full model (every term of the scene, the finest fidelity, a fine step) and
// the reduced one are driven through the same probe motions, and compared.
//
// Motions that a plan is for: starts of the scene's start distribution; commands that move at up to
// limits.speed and change speed in 0.1 s; insertion to the success depth, sideways pushes, tilting
// and withdrawal, as long as the force at the holder stays below limits.force.
//
// Errors are those of sim/analysis/sampled_run.hpp, at 1 kHz. The full model steps as control does:
// without drag and inertia it too takes one step per command, 1 ms, which is the input and no
// approximation. Where the fibre snaps or sticks, commands sampled and steps taken more finely end
// elsewhere: by how much is measured, and counts in the bound where a scene asks for events
// coarser than 1 nm.
//
// A term is left out where the largest force it has in any probe could not change the result by a
// fifth of the tolerance; where the fibre snaps, sticks by friction or is dragged, by 1e-4 of it,
// since there small forces decide where it comes to rest. What is chosen is then run, and has to
// stay below a third of the tolerance in every probe, with drag below a twentieth: the shorter the
// rest of the fibre that liquid holds, the faster it moves, and motions differ in that by as much.
// The bound is what was measured over the share it may have: other motions than the probes differ
// by more.
//
// Without drag, flow and inertia nothing depends on time, and the step is that of control, 1 ms.
// With them it is the longest that is good enough. A fibre that neither rubs nor adheres, or that
// has inertia, is run in the finest step and in the longer one: where even the finest two differ by
// more than the measured error may be, the full model is the plan. With friction or adhesion no
// step, however fine, ends at the same place after a snap, and a step is judged between such
// events: along intervals of 0.1 s, the time in which a command changes speed, against eight times
// finer steps from the same state, of 95 % of the intervals. What is left out is then measured in
// that step.
//
// Statistics bear more than a motion does. Where a fibre snaps and sticks, a hand that is off by a
// thousandth of the clearance ends elsewhere by a tenth of it, and a success rate over scattered
// starts does not change. A plan for the success rate therefore asks that every step is what the
// full model would do from the same state: the motion is then the full model's for a hand that is
// off by no more than that. Its bound is that error of a step, of 95 % of the steps of four probes.
// Terms may be left out by their share whether it sticks or not, drag is compared over the control
// period, and smooth intervals are followed along the tangent to 0.3 or 0.03 of the tolerance.
// Scenes with inertia are planned for the motion.
//
// The full model follows smooth intervals along the tangent (sim/solver/extrapolation.hpp) where
// and as closely as the scene does, and locates events as it does: to 0.1 nm of the hand's travel,
// in scenes with printed surface laws or adhesion not at all unless they ask for it.
//
// Where the scene does not say which dynamics it has, inertia is judged by the acceleration of the
// command, and where it states how the fibre is damped (holder.loss_factor, eta) by how long a snap
// rings: an amplitude of a clearance falls to the tolerance in
//   t = 2 log(1/tolerance)/(eta omega_1),
// and how far the hand goes until then, at limits.speed over the clearance, is what leaving inertia
// out changes, as of any event that comes later. Without damping the bound does not cover how long
// a fibre rings where it snaps or hits. Parts with a tolerance are planned for as a pair of the
// nominal diameters.
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
  double step;  // longest step in time [s]
  // Error to which smooth intervals follow the tangent, of the clearance [-]; 0: none does.
  double tangent = 0;
  double force_scale;  // what force errors are relative to [N]
  double error_bound;  // of tip over clearance and of force over force_scale
  // By how much the same motions, sampled twice as finely and taken in steps half as long, each of
  // them solved, end elsewhere in the full model, in the same measure; whether that counts in the
  // bound, events not being located.
  double sampled_twice = 0;
  bool sampling_counts = false;
  double step_error = 0;  // what of the bound its steps are, or all that is chosen with them [-]
  // How long a snap of a clearance rings until it is within the tolerance [s]; infinite where the
  // scene states no damping.
  double rings = INFINITY;
  Json document;  // the planned scene
  // It was stopped: nothing is left out, the error bound is infinite, the largest forces are those
  // of the probes that were run.
  bool partial = false;
};

// Called between the runs of a plan, with those that are done and those that may be needed, of
// which a good plan is found after some. False stops it.
using PlanProgress = std::function<bool(std::size_t runs, std::size_t most)>;

// Whatever accuracy the scene itself asks for; 1e-6 <= tolerance <= 0.5. Deterministic; takes about
// a second. Throws BadInput if the tolerance is out of range.
Plan make_plan(const Scene& scene, double tolerance, const PlanProgress& go_on = {},
               PlanFor quantity = PlanFor::motion);

// The scene itself, or where it states an accuracy the planned one. Throws BadInput, and what
// `go_on` throws.
Scene planned(const Scene& scene, const PlanProgress& go_on = {});

}  // namespace ferrule
