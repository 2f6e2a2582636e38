// Which terms, fidelity, dynamics and step a scene needs for a tolerance: both speed and accuracy,
// by measurement. The full model (every term of the scene, the finest fidelity, a fine step) and
// the reduced one are driven through the same probe motions, and compared.
//
// Motions that a plan is for: starts of the scene's start distribution; commands that move at up to
// limits.speed and change speed in 0.1 s; insertion to the success depth, sideways pushes, tilting
// and withdrawal, as long as the force at the holder stays below limits.force.
//
// Errors are those of sim/plan/sampled_run.hpp, at 1 kHz. The full model steps as control does:
// without drag and inertia it too takes one step per command, 1 ms, which is the input and no
// approximation. Where the fibre snaps or sticks, commands sampled more finely end elsewhere; the
// bound does not cover that.
//
// A term is left out where the largest force it has in any probe could not change the result by a
// fifth of the tolerance; where the fibre snaps, sticks by friction or is dragged, by 1e-4 of it,
// since there small forces decide where it comes to rest, and so for a coarser fidelity. What is
// chosen is then run, and has to stay below a third of the tolerance in every probe, with drag
// below a twentieth: the shorter the rest of the fibre that liquid holds, the faster it moves, and
// motions differ in that by as much. Without drag and inertia nothing depends on time, and the step
// is that of control, 1 ms. Where even the finest two steps differ by more than that, the full
// model is the plan. The bound is what was measured over the share it may have: other motions than
// the probes differ by more.
//
// Where the scene does not say which dynamics it has, inertia is judged by the acceleration of the
// command alone: the bound does not cover how long a fibre without damping rings where it snaps or
// hits. Parts with a tolerance are planned for as a pair of the nominal diameters.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sim/scene/scene.hpp"

namespace ferrule {

struct PlannedTerm {
  std::string name;  // as in the table of terms, "curl" or "inertia"
  bool kept;
  std::string fidelity;   // how it is computed; "none" where left out
  double max_force;       // largest in any probe [N]
  double relative_error;  // of its force where kept; what leaving it out changes at most otherwise
  State state;            // where it was largest: what a benchmark of its cost evaluates
};

struct Plan {  // NOLINT(bugprone-exception-escape): the JSON library moves without one
  double tolerance;
  // Those of the scene, in the order of the table of terms, then curl, if it has it, and inertia,
  // unless the scene says that it is quasi-static.
  std::vector<PlannedTerm> terms;
  Dynamics dynamics;
  double step;         // longest step in time [s]
  double force_scale;  // what force errors are relative to [N]
  double error_bound;  // of tip over clearance and of force over force_scale
  Json document;       // the planned scene
  // It was stopped: nothing is left out, the error bound is infinite, the largest forces are those
  // of the probes that were run.
  bool partial = false;
};

// Called between the runs of a plan, with those that are done and those that may be needed, of
// which a good plan is found after some. False stops it.
using PlanProgress = std::function<bool(std::size_t runs, std::size_t most)>;

// Whatever accuracy the scene itself asks for; 1e-6 <= tolerance <= 0.5. Deterministic; takes some
// seconds. Throws BadInput if the tolerance is out of range.
Plan make_plan(const Scene& scene, double tolerance, const PlanProgress& go_on = {});

// The scene itself, or where it states an accuracy the planned one. Throws BadInput, and what
// `go_on` throws.
Scene planned(const Scene& scene, const PlanProgress& go_on = {});

}  // namespace ferrule
