#include "sim/solver/sub_step.hpp"

#include <algorithm>
#include <cmath>

#include "sim/solver/find_root.hpp"
#include "sim/solver/friction_coupling.hpp"
#include "sim/solver/predictor.hpp"
#include "sim/terms/contact.hpp"

namespace ferrule {
namespace {

constexpr int kMaxCouplings = 12;           // of friction and pose
constexpr int kCouplingEvaluations = 16;    // for them, after a minimum at given limits
constexpr int kReturnEvaluations = 2;       // kept for returning to where the sub-step began
constexpr double kCouplingResidual = 2e-2;  // of the sum of all forces: coupled as long as below

// The frozen quantities once more, at the iterate; time still runs from the step's start.
FrozenCoefficients freeze_again(const World& world, const State& start,
                                const FrozenCoefficients& first, const Pose& tip) noexcept {
  State moved = start;
  moved.tip = tip;
  moved.command = first.command.full();
  moved.side = first.contact.side;
  const FrozenCoefficients now = freeze(world, moved, moved.command, 0);
  FrozenCoefficients again = first;
  again.length = now.length;
  again.contact = now.contact;
  again.friction = now.friction;
  return again;
}

void evaluate_at(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                 Iterate& iterate) noexcept {
  iterate.tip = tip;
  iterate.potential = Potential(world, frozen, tip);
  ++iterate.evaluations;
}

bool is_near(const World& world, const Iterate& iterate) noexcept {
  return residual(world, iterate.potential.gradient) <=
         kCouplingResidual * iterate.potential.force_scale;
}

// Does a contact in friction open?
bool opens(const World& world, const FrozenCoefficients& frozen, const Iterate& iterate,
           int place) noexcept {
  return frozen.friction[place].acts &&
         !(sticking_stiffness(world, frozen, iterate.tip, iterate.potential, place) > 0);
}

// Ends the friction of contacts that have opened; whether there were any.
bool drop_opened(const World& world, const Iterate& iterate, FrozenCoefficients& frozen) noexcept {
  bool any = false;
  for (int place = 0; place < kContactPlaces; ++place)
    if (opens(world, frozen, iterate, place)) {
      frozen.friction[place].acts = false;
      any = true;
    }
  return any;
}

// Goes on to where the friction limits are those of the contacts there; whether it got there.
// Contacts that less friction opens later are held by no minimum at given limits; they are followed
// by Newton's method in limits and pose together, as long as the residual stays small and the
// contacts closed. From a step where they do not the search returns, with limits halfway.
bool couple_friction(const World& world, const State* before, int max_evaluations,
                     FrozenCoefficients& frozen, Iterate& iterate) noexcept {
  const double tolerance = world.numerics.solver.friction_tolerance;
  bool final = false;
  for (int round = 0; round < kMaxCouplings; ++round) {
    if (iterate.converged && iterate.evaluations < max_evaluations &&
        drop_opened(world, iterate, frozen)) {
      final = false;
      evaluate_at(world, frozen, iterate.tip, iterate);
      iterate.converged = false;
      note(iterate, SolverStage::friction, "a contact opened: its friction ends");
      minimise(world, frozen, max_evaluations, true, iterate, before);
      if (!iterate.converged) return false;
    }
    if (final) return true;
    const FrictionCoupling coupling(world, frozen, iterate.tip, iterate.potential);
    const bool agrees = coupling.largest_error() <= tolerance;
    if (agrees && iterate.converged) return true;
    if (iterate.evaluations >= max_evaluations) return false;
    const NewtonStep newton = stationary_step(world, frozen, iterate);
    const auto start = frozen.friction;
    const auto move = CoupledModel(newton, coupling).step(frozen);
    iterate.converged = false;
    if (move) {
      final = agrees && final_newton_step(world, start, frozen, *move, iterate);
      if (final) continue;
      const PoseVector from = iterate.tip;
      evaluate_at(world, frozen, retract(world, frozen, from, *move), iterate);
      const bool any_opens =
          opens(world, frozen, iterate, kEnd) || opens(world, frozen, iterate, kSide);
      if (is_near(world, iterate) && !any_opens) {
        note(iterate, SolverStage::friction, "limits and pose moved together", world, *move);
        continue;
      }
      if (iterate.evaluations >= max_evaluations) return false;
      for (std::size_t at = 0; at < kContactPlaces; ++at)
        frozen.friction[at].limit = 0.5 * (start[at].limit + frozen.friction[at].limit);
      evaluate_at(world, frozen, from, iterate);
      note(iterate, SolverStage::friction,
           any_opens ? "returned, limits halfway: a contact opened"
                     : "returned, limits halfway: residual grew");
    }
    minimise(world, frozen, max_evaluations, true, iterate, before);
    if (!iterate.converged) return false;
  }
  return final;
}

// A sharp end that fell off the face, where bore and cone are not looked at, may end deep in them:
// it goes on from the edge, found on a straight path.
void restart_at_edge(const World& world, const State& state, int max_evaluations,
                     FrozenCoefficients& frozen, Iterate& iterate) noexcept {
  const auto on_face = [&](const PoseVector& tip) {
    return side_of(world, tip, frozen.contact.side) == EdgeSide::face;
  };
  const auto middle = [](const PoseVector& a, const PoseVector& b) {
    return PoseVector(Pose(0.5 * (a.full() + b.full())));
  };
  const PoseVector off =
      bisect(Bracket<PoseVector>{state.tip, iterate.tip}, 30, on_face, middle).fails;
  frozen = freeze_again(world, state, frozen, off.full());
  evaluate_at(world, frozen, off, iterate);
  iterate.converged = false;
  note(iterate, SolverStage::newton, "restarted at the edge that the end fell off");
  minimise(world, frozen, max_evaluations, true, iterate);
}

// Puts a prediction that has lost contacts which adhesion held back to the depths at which they
// were: a tenth of a nanometre beyond what holds, a search would not find it again.
void restore_contacts(const World& world, const State& state, const FrozenCoefficients& frozen,
                      Iterate& iterate) noexcept {
  if (!std::holds_alternative<Adhesion>(world.laws.adhesion)) return;
  const Contacts now = contacts(world, frozen, iterate.tip, iterate.potential);
  PoseVector tip = iterate.tip;
  bool any = false;
  for (std::size_t place = 0; place < kContactPlaces; ++place) {
    const ContactDepth& depth = iterate.potential.depth[place];
    if (!state.contact[place].closed || now.contact[place].closed || depth.value == -INFINITY)
      continue;
    const double before = contact_depths(world, frozen.contact, state.tip)[place].value;
    PoseVector normal = depth.by_pose(tip.t);
    normal.t.setZero();
    if (before == -INFINITY || !(normal.dot(normal) > 0)) continue;
    tip += (before - depth.value) / normal.dot(normal) * normal;
    any = true;
  }
  if (!any) return;
  evaluate_at(world, frozen, tip, iterate);
  note(iterate, SolverStage::predictor, "lost contacts put back to their depths");
}

// Sliding off an edge ends on it, where one surface stops and the next is not looked at yet: frozen
// again there, the search goes on.
void go_past_edges(const World& world, const State& state, int max_evaluations, const State* before,
                   FrozenCoefficients& frozen, Iterate& iterate) noexcept {
  while (!iterate.converged && iterate.evaluations < max_evaluations) {
    if (before && !iterate.at_edge) break;
    const EdgeSide side = frozen.contact.side;
    frozen = freeze_again(world, state, frozen, iterate.tip.full());
    const int spent = iterate.evaluations;
    evaluate_at(world, frozen, iterate.tip, iterate);
    note(iterate, SolverStage::newton, "frozen again where the search ended");
    minimise(world, frozen, max_evaluations, side == frozen.contact.side, iterate, before);
    if (iterate.evaluations == spent + 1) break;
  }
}

// A search that ended early may have begun where the prediction was, higher than the start is, or
// have diverged, far farther than the hand is: the end stays where it was then.
void reject_divergence(const World& world, const State& state, const Pose& command, double dt,
                       int max_evaluations, FrozenCoefficients& frozen, Iterate& iterate) noexcept {
  const PoseVector tip(state.tip);
  const EdgeSide side = frozen.contact.side;
  const bool fell = state.side == EdgeSide::face && !world.end.rounded() &&
                    side_of(world, iterate.tip, side) == EdgeSide::throat;
  if (iterate.converged && !fell) return;
  const FrozenCoefficients first = freeze(world, state, command, dt);
  const Potential start(world, first, tip);
  ++iterate.evaluations;
  if (fell && side == EdgeSide::face) {
    frozen = first;
    restart_at_edge(world, state, max_evaluations, frozen, iterate);
  }
  const double most = world.numerics.solver.snap_ratio *
                      (length_of(world, frozen, frozen.command - tip) + world.annulus.clearance());
  if (!(start.value < iterate.potential.value) &&
      (iterate.converged || length_of(world, frozen, iterate.tip - tip) < most))
    return;
  frozen = first;
  iterate.tip = tip;
  iterate.potential = start;
  iterate.converged = false;
  note(iterate, SolverStage::newton, "diverged: stays where the sub-step began");
}

}  // namespace

Iterate solve_sub_step(const World& world, const StepResult& now, const Pose& command, double dt,
                       int max_evaluations, double* event, FrozenCoefficients& frozen,
                       StepTrace* trace) noexcept {
  const State& state = now.state;
  const int most = max_evaluations - kReturnEvaluations;
  const int few = event ? std::min(world.numerics.solver.divisible_evaluations, most) : most;
  const bool holds_still = world.dynamics == Dynamics::inertial && dt == 0;
  const State* const before = event ? &state : nullptr;
  const auto friction = frozen.friction;

  // Predict.
  Prediction end;
  end.tip = state.tip;
  end.reason = "no move: over no time nothing with inertia does";
  if (!holds_still) end = predict(world, now, frozen);
  if (!end.valid) frozen.friction = friction;
  Iterate iterate(world, frozen, end.tip, trace);
  iterate.converged = holds_still;
  note(iterate, SolverStage::predictor, end.reason, world, end.move);
  if (event && end.valid &&
      contact_set_changed(state, contacts(world, frozen, iterate.tip, iterate.potential))) {
    *event = contact_onset(world, state, end, iterate.potential);
    note(iterate, SolverStage::predictor, "ends: the contact set changes in the prediction");
    return iterate;
  }

  // Correct.
  if (end.valid && !event) restore_contacts(world, state, frozen, iterate);
  bool coupled = false;
  if (end.valid && !correct(world, frozen, end, now.warm_start.linearization.curvature, iterate)) {
    frozen.friction = friction;
    evaluate_at(world, frozen, state.tip, iterate);
    note(iterate, SolverStage::corrector, "prediction error too large: back to the start");
  } else if (end.valid && frozen.has_friction() && is_near(world, iterate)) {
    coupled = couple_friction(world, before, few, frozen, iterate);
  }

  // Minimise.
  if (!iterate.converged) minimise(world, frozen, few, false, iterate, before);
  go_past_edges(world, state, few, before, frozen, iterate);

  // Couple friction.
  if (iterate.converged && !coupled && frozen.has_friction()) {
    const FrozenCoefficients lagged = frozen;
    const Iterate minimum = iterate;
    couple_friction(world, before, std::min(most, iterate.evaluations + kCouplingEvaluations),
                    frozen, iterate);
    if (!iterate.converged) {  // limits that lag behind, then
      const int iterations = iterate.iterations, evaluations = iterate.evaluations;
      frozen = lagged;
      iterate = minimum;
      iterate.iterations = iterations;
      iterate.evaluations = evaluations;
      note(iterate, SolverStage::friction, "not coupled: the limits of the minimum are kept");
    }
  }

  if (!event) reject_divergence(world, state, command, dt, max_evaluations, frozen, iterate);
  iterate.spent = iterate.evaluations >= most;
  return iterate;
}

}  // namespace ferrule
