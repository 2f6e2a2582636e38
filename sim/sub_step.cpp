#include "sim/sub_step.hpp"

#include <algorithm>
#include <cmath>

#include "sim/friction_limits.hpp"
#include "sim/prediction.hpp"

namespace ferrule {
namespace {

constexpr int kMostTurns = 4;        // at edges, in one sub-step
constexpr double kSameLimit = 1e-4;  // of a friction limit: what it may miss
constexpr double kStaysNear = 2e-2;  // of the sum of all forces
constexpr int kMostSettling = 12;
constexpr int kLimitEvaluations = 16;  // for the limits of friction, in one sub-step

// The frozen quantities once more, where the end has got to; time still runs from the step's start.
FrozenCoefficients freeze_again(const World& world, const State& start,
                                const FrozenCoefficients& first, const Pose& tip) noexcept {
  State there = start;
  there.tip = tip;
  there.command = first.command.full();
  there.side = first.contact.side;
  const FrozenCoefficients now = freeze(world, there, there.command, 0);
  FrozenCoefficients again = first;
  again.length = now.length;
  again.contact = now.contact;
  again.friction = now.friction;
  return again;
}

// Has a contact that rubs come apart?
bool comes_apart(const World& world, const Minimum& found, const FrozenCoefficients& frozen,
                 int place) noexcept {
  return frozen.friction[place].acts &&
         !(stuck_stiffness(world, frozen, found.tip, found.there, place) > 0);
}
bool come_apart(const World& world, const Minimum& found,
                const FrozenCoefficients& frozen) noexcept {
  return comes_apart(world, found, frozen, kEnd) || comes_apart(world, found, frozen, kSide);
}

// Ends the friction of contacts that have; whether there were any.
bool let_go(const World& world, const Minimum& found, FrozenCoefficients& frozen) noexcept {
  bool any = false;
  for (int place = 0; place < kContactPlaces; ++place)
    if (comes_apart(world, found, frozen, place)) {
      frozen.friction[place].acts = false;
      any = true;
    }
  return any;
}

// Goes on from a minimum to where the friction limits are those of the contacts there; whether it
// got there. Contacts that less friction lets go later are held by no minimum of given limits; they
// are followed by Newton's method in both together, as long as that stays near and contacts stay
// closed: from a move where they do not, the search goes back, with limits halfway.
bool settle_limits(const World& world, const State* before, int most_evaluations,
                   FrozenCoefficients& frozen, Minimum& found) noexcept {
  bool met = false;
  for (int round = 0; round < kMostSettling; ++round) {
    if (found.converged && found.evaluations < most_evaluations && let_go(world, found, frozen)) {
      met = false;
      found.there = Potential(world, frozen, found.tip);
      ++found.evaluations;
      found.converged = false;
      minimise(world, frozen, most_evaluations, true, found, before);
      if (!found.converged) return false;
    }
    if (met) return true;
    const FrictionLimits limits(world, frozen, found.tip, found.there);
    const bool settled = limits.largest_miss() <= kSameLimit;
    if (settled && found.converged) return true;
    if (found.evaluations >= most_evaluations) return false;
    const Energy& bore = found.there.bore;
    const NewtonStep newton(world, frozen,
                            without_friction(frozen, found.tip, bore.gradient, bore.hessian),
                            found.tip, 1, Pivots::as_they_are);
    const std::array limit = {frozen.friction[kEnd].limit, frozen.friction[kSide].limit};
    const auto move = limits.settle(newton, frozen);
    found.converged = false;
    if (move) {
      met = settled && final_newton_step(world, frozen, *move, found);
      if (met) continue;
      const PoseVector from = found.tip;
      found.tip = moved_along(world, frozen, from, *move);
      found.there = Potential(world, frozen, found.tip);
      ++found.evaluations;
      if (residual(world, found.there.gradient) <= kStaysNear * found.there.force_scale &&
          !come_apart(world, found, frozen))
        continue;
      if (found.evaluations >= most_evaluations) return false;
      found.tip = from;
      for (std::size_t at = 0; at < kContactPlaces; ++at)
        frozen.friction[at].limit = 0.5 * (limit[at] + frozen.friction[at].limit);
      found.there = Potential(world, frozen, from);
      ++found.evaluations;
    }
    minimise(world, frozen, most_evaluations, true, found, before);
    if (!found.converged) return false;
  }
  return met;
}

// Goes on from where a search that fell off the face left that, on a straight way.
void go_on_from_edge(const World& world, const State& state, int most_evaluations,
                     FrozenCoefficients& frozen, Minimum& found) noexcept {
  constexpr int kBisections = 30;
  PoseVector on_face(state.tip), off = found.tip;
  for (int n = 0; n < kBisections; ++n) {
    const PoseVector middle{Pose(0.5 * (on_face.full() + off.full()))};
    (side_of(world, middle, frozen.contact.side) == EdgeSide::face ? on_face : off) = middle;
  }
  frozen = freeze_again(world, state, frozen, off.full());
  found.tip = off;
  found.there = Potential(world, frozen, off);
  ++found.evaluations;
  found.converged = false;
  minimise(world, frozen, most_evaluations, true, found);
}

// Puts a prediction that has lost contacts which adhesion held back to the depths at which they
// were: a tenth of a nanometre beyond what holds, a search would not find it again.
void hold_contacts(const World& world, const State& state, const FrozenCoefficients& frozen,
                   Minimum& found) noexcept {
  if (!std::holds_alternative<Adhesion>(world.laws.adhesion)) return;
  const Contacts now = contacts(world, frozen, found.tip, found.there);
  bool any = false;
  for (std::size_t place = 0; place < kContactPlaces; ++place) {
    const ContactDepth& depth = found.there.depth[place];
    if (!state.contact[place].closed || now.contact[place].closed || depth.value == -INFINITY)
      continue;
    const double before = contact_depths(world, frozen.contact, state.tip)[place].value;
    PoseVector normal = depth.by_pose(found.tip.t);
    normal.t.setZero();
    if (before == -INFINITY || !(normal.dot(normal) > 0)) continue;
    found.tip += (before - depth.value) / normal.dot(normal) * normal;
    any = true;
  }
  if (!any) return;
  found.there = Potential(world, frozen, found.tip);
  ++found.evaluations;
}

}  // namespace

Minimum solve_sub_step(const World& world, const State& state, double dt, int few,
                       int most_evaluations, double* event, FrozenCoefficients& frozen) noexcept {
  const bool holds_still = world.dynamics == Dynamics::inertial && dt == 0;
  const State* const before = event ? &state : nullptr;
  const auto friction = frozen.friction;
  bool settled = false;
  const Prediction end =
      holds_still ? Prediction{false, state.tip, {}, {}, 0} : predict(world, state, frozen);
  if (!end.valid) frozen.friction = friction;
  Minimum found(world, frozen, end.tip);
  found.converged = holds_still;
  if (event && end.valid && hits(state, contacts(world, frozen, found.tip, found.there))) {
    *event = first_touch(world, state, end, found.there);
    return found;
  }
  if (end.valid && !event) hold_contacts(world, state, frozen, found);
  if (end.valid && !correct(world, frozen, end, state.linearization->curvature, found)) {
    frozen.friction = friction;
    found.tip = state.tip;
    found.there = Potential(world, frozen, state.tip);
    ++found.evaluations;
  } else if (end.valid && frozen.rubs() &&
             residual(world, found.there.gradient) <= kStaysNear * found.there.force_scale) {
    settled = settle_limits(world, before, few, frozen, found);
  }
  if (!found.converged) minimise(world, frozen, few, false, found, before);
  // Sliding off an edge ends on it, where one surface stops and the next is not looked at yet.
  for (int turn = 0; turn < kMostTurns && !found.converged; ++turn) {
    if (found.evaluations >= few || (event && !found.at_edge)) break;
    const EdgeSide side = frozen.contact.side;
    frozen = freeze_again(world, state, frozen, found.tip.full());
    const int spent = found.evaluations;
    found.there = Potential(world, frozen, found.tip);
    ++found.evaluations;
    minimise(world, frozen, few, side == frozen.contact.side, found, before);
    if (found.evaluations == spent + 1) break;
  }
  if (found.converged && !settled && frozen.rubs()) {
    const FrozenCoefficients held = frozen;
    const Minimum minimum = found;
    settle_limits(world, before, std::min(most_evaluations, found.evaluations + kLimitEvaluations),
                  frozen, found);
    if (!found.converged) {  // limits that lag behind, then
      const int iterations = found.iterations, evaluations = found.evaluations;
      frozen = held;
      found = minimum;
      found.iterations = iterations;
      found.evaluations = evaluations;
    }
  }
  return found;
}

void stay_if_astray(const World& world, const State& state, const Pose& command, double dt,
                    int most_evaluations, FrozenCoefficients& frozen, Minimum& found) noexcept {
  const PoseVector tip(state.tip);
  const EdgeSide side = frozen.contact.side;
  const bool fell = state.side == EdgeSide::face && !world.end.rounded() &&
                    side_of(world, found.tip, side) == EdgeSide::throat;
  if (found.converged && !fell) return;
  const FrozenCoefficients first = freeze(world, state, command, dt);
  const Potential here(world, first, tip);
  ++found.evaluations;
  if (fell && side == EdgeSide::face) {
    frozen = first;
    go_on_from_edge(world, state, most_evaluations, frozen, found);
  }
  const double most =
      kSnap * (travel_of(world, frozen, frozen.command - tip) + world.annulus.clearance());
  if (!(here.value < found.there.value) &&
      (found.converged || travel_of(world, frozen, found.tip - tip) < most))
    return;
  frozen = first;
  found.tip = tip;
  found.there = here;
  found.converged = false;
}

}  // namespace ferrule
