#include "sim/step.hpp"

#include <algorithm>
#include <cmath>

#include "sim/newton.hpp"
#include "sim/potential.hpp"

namespace ferrule {
namespace {

constexpr int kMaxIterations = 100;
constexpr int kMaxHalvings = 50;
constexpr int kMaxSubsteps = 8192;
constexpr int kMostHalvings = 2;          // of a sub-step in which the minimum is not found
constexpr int kMostEventHalvings = 10;    // where the world asks for events to be located
constexpr int kMostTurns = 4;             // at edges, in one sub-step
constexpr double kForceTolerance = 1e-9;  // relative to the sum of all force magnitudes
constexpr double kForceFloor = 1e-14;     // [N]
constexpr double kResolution = 1e-15;     // a Newton step shorter than this is none [m]
constexpr int kPatience = 5;              // iterations after which being near is enough
constexpr double kNearForce = 3e-7;       // relative to the same sum, and within so much of the
constexpr double kNearMove = 2e-5;        // clearance: the last Newton step needs no evaluation
constexpr double kShortMove = 0.1;        // of the clearance: as far as known forces tell
constexpr double kStraight = 0.3;  // of the gradient, that known forces may be wrong by there

// A search for the minimum: where it has got to.
struct Minimum {
  Minimum(const World& world, const Lagged& lagged, const PoseVector& start) noexcept
      : tip(start), there(world, lagged, start) {}

  PoseVector tip;
  Potential there;
  PoseVector curvature = {};  // KnownForces::curvature
  int iterations = 0;
  bool converged = false;
};

// Residual of a gradient [N], tilts weighed by the length that makes both stiffnesses equal.
double residual(const World& world, const PoseVector& gradient) noexcept {
  return std::max({std::abs(gradient.x), gradient.e.cwiseAbs().maxCoeff(),
                   gradient.t.cwiseAbs().maxCoeff() / world.holder.tilt_length});
}

// How far a move takes the end or the other end of the inserted length [m].
double way_of(const World& world, const Lagged& lagged, const PoseVector& move) noexcept {
  return move.length() + move.t.norm() * (lagged.length + world.annulus.fibre_radius);
}

// Takes what is left of the way, where it is so short that the forces change along it as the
// Hessian says; false where it is not.
bool take_the_rest(const World& world, const Lagged& lagged, const PoseVector& rest,
                   Minimum& found) noexcept {
  Potential& there = found.there;
  if (!(residual(world, there.gradient) <= kNearForce * there.force_scale &&
        way_of(world, lagged, rest) <= kNearMove * world.annulus.clearance()))
    return false;
  found.tip += rest;
  there.bore.gradient += there.bore.hessian.times(rest);
  found.converged = true;
  return true;
}

// Newton's method with a line search, from where `found` is.
void minimise(const World& world, const Lagged& lagged, Minimum& found) noexcept {
  const double clearance = world.annulus.clearance();
  const double radius = world.annulus.fibre_radius, lever = lagged.length + radius;
  for (; found.iterations < kMaxIterations; ++found.iterations) {
    const Potential& here = found.there;
    const double left = residual(world, here.gradient);
    if (left <= kForceFloor + kForceTolerance * here.force_scale) {
      found.converged = true;
      break;
    }
    const PoseVector newton = newton_direction(world, here);
    const double turn = newton.t.norm() * lever;
    if (newton.length() + turn < kResolution) {
      found.converged = true;
      break;
    }
    if (found.iterations >= kPatience && take_the_rest(world, lagged, newton, found)) break;
    // Far from everything the potential is a quadratic and any length is right; among surface
    // forces a step longer than the clearance tells nothing.
    const double reach = std::max(newton.e.norm(), turn);
    double fraction = lagged.length > 0 && reach > clearance ? clearance / reach : 1;
    const double slope = here.gradient.dot(newton);
    bool moved = false;
    for (int halving = 0; halving < kMaxHalvings; ++halving, fraction *= 0.5) {
      PoseVector trial = found.tip;
      trial += fraction * newton;
      const Potential there(world, lagged, trial);
      // Where the drop drowns in rounding, a smaller residual decides.
      const double rounding =
          1e-15 * (here.value_scale + here.force_scale * (found.tip.length() + radius));
      const bool lower = there.value <= here.value + 1e-4 * fraction * slope;
      const bool level =
          there.value <= here.value + rounding && residual(world, there.gradient) < left;
      if (lower || level) {
        moved = trial.full() != found.tip.full();
        found.tip = trial;
        found.there = there;
        break;
      }
    }
    if (!moved) {  // rounding leaves nothing lower
      found.converged = left <= kNearForce * here.force_scale;
      break;
    }
  }
}

// Where the forces known from the last step say that this one ends.
struct Foretold {
  bool told = false;
  PoseVector tip;
  Eliminated hessian;
  PoseVector move = {};
  double slope = 0;  // of the energy along the move, < 0
};

Foretold foretell(const World& world, const Lagged& lagged, const State& state) noexcept {
  Foretold end;
  end.tip = state.tip;
  if (!state.known || state.known->at != state.tip) return end;
  Energy here = potential_at_start(world, lagged, *state.known);
  here.gradient += state.known->curvature;
  if (!end.hessian.of(here.hessian)) return end;
  end.move = end.hessian.solve(here.gradient);
  end.slope = end.move.dot(here.gradient);
  const double way = way_of(world, lagged, end.move);
  if (!(end.slope < 0 && way >= kResolution && way <= kShortMove * world.annulus.clearance()))
    return end;
  end.tip += end.move;
  end.told = true;
  return end;
}

// Goes on from where forces known before told that the step ends, and their evaluation there. False
// if they told wrong.
bool follow(const World& world, const Lagged& lagged, const Foretold& end,
            const PoseVector& curvature, Minimum& found) noexcept {
  const Potential& there = found.there;
  if (!(std::abs(end.move.dot(there.gradient)) <= -kStraight * end.slope)) return false;
  found.iterations = 1;
  found.curvature = curvature;
  found.curvature += there.gradient;
  if (residual(world, there.gradient) <= kNearForce * there.force_scale)
    take_the_rest(world, lagged, end.hessian.solve(there.gradient), found);
  return true;
}

// Contacts after a step: new ones stick where they are, slipping ones drag their stuck point along.
void update_contacts(const Lagged& lagged, const Contacts& now, State& state) noexcept {
  for (int place = 0; place < kContactPlaces; ++place) {
    ContactState& contact = state.contact[place];
    const bool was_closed = contact.closed;
    const Vector3d stuck = contact.stuck;
    contact = now.contact[place];
    if (!contact.closed) continue;
    const LaggedFriction& friction = lagged.friction[place];
    if (!was_closed || !friction.acts) {
      contact.stuck = now.material[place];
      continue;
    }
    contact.stuck = stuck;
    const Vector3d stretch = friction.tangential * (now.material[place] - stuck);
    const double allowed = friction.limit / friction.stiffness;
    if (stretch.norm() > allowed)
      contact.stuck = now.material[place] - stretch * (allowed / stretch.norm());
  }
}

// The lagged quantities once more, where the end has got to; time still runs from the step's start.
Lagged lag_again(const World& world, const State& start, const Lagged& first,
                 const Pose& tip) noexcept {
  State there = start;
  there.tip = tip;
  there.side = first.contact.side;
  const Lagged now = lag(world, there, first.hand.full(), 0);
  Lagged again = first;
  again.length = now.length;
  again.contact = now.contact;
  again.friction = now.friction;
  return again;
}

// Velocities after a step that ends at `tip`, by the rule that the step used.
void update_velocity(const Lagged& lagged, const Pose& tip, double dt, State& state) noexcept {
  if (!lagged.inertial) return;
  const Pose velocity = lagged.second_order
                            ? Pose((3 * tip - 4 * state.tip + state.tip_before) / (2 * dt))
                            : Pose((tip - state.tip) / dt);
  state.velocity_before = state.velocity;
  state.tip_before = state.tip;
  state.velocity = velocity;
  state.dt_before = dt;
}

// Nothing near the fibre now or where the hand goes, and no inertia: it hangs on the holder alone.
bool flies_free(const World& world, const State& state, const Pose& hand) noexcept {
  if (world.dynamics == Dynamics::inertial) return false;
  const double reach = world.profile.lead_in_length + world.annulus.clearance();
  if (!(std::min(state.tip[0], state.hand[0]) > reach)) return false;
  const double lever = world.annulus.fibre_radius;
  const Pose goal = hand + world.holder.sag;
  const auto tilt = [](const Pose& p) { return std::abs(p[3]) + std::abs(p[4]); };
  return std::min({state.tip[0], state.hand[0], goal[0]}) - lever * (tilt(state.tip) + tilt(goal)) >
         reach;
}

int substeps_for(const World& world, const State& state, const Pose& hand, double dt) noexcept {
  int fewest = 1;
  if (dt > world.longest_step)
    fewest = static_cast<int>(
        std::clamp<double>(std::ceil(dt / world.longest_step * (1 - 1e-9)), 1, kMaxSubsteps));
  const PoseVector move = PoseVector(hand) - state.hand;
  const double clearance = world.annulus.clearance();
  const double lever = state.inserted_length() + world.annulus.fibre_radius;
  const double travel = move.length() + lever * move.t.norm();
  if (travel <= 0.5 * clearance) return fewest;
  // Clear of the ferrule before and after: nothing on the way.
  const double nearest = std::min({state.tip[0], state.hand[0], hand[0]}) -
                         lever * (state.tip.tail<2>().norm() + hand.tail<2>().norm());
  if (nearest > world.profile.lead_in_length + clearance) return fewest;
  return std::max(
      fewest, static_cast<int>(std::min<double>(std::ceil(2 * travel / clearance), kMaxSubsteps)));
}

// Did something begin or end, or did the end move by far more than the hand?
bool is_event(const State& before, const Contacts& now, EdgeSide side, const Pose& tip,
              double travel) noexcept {
  for (std::size_t place = 0; place < kContactPlaces; ++place)
    if (before.contact[place].closed != now.contact[place].closed ||
        before.contact[place].branch != now.contact[place].branch)
      return true;
  return before.bridge != now.bridge || before.side != side ||
         (tip - before.tip).head<3>().norm() > 10 * travel;
}

// One sub-step from result.state to `command`, halved where the minimum is not found or an event is
// to be located.
void advance(const World& world, const Pose& command, double dt, int depth,
             StepResult& result) noexcept {
  State& state = result.state;
  Lagged lagged = lag(world, state, command, dt);
  const bool holds_still = world.dynamics == Dynamics::inertial && dt == 0;
  const Foretold end =
      holds_still ? Foretold{false, state.tip, {}} : foretell(world, lagged, state);
  Minimum found(world, lagged, end.tip);
  if (end.told && !follow(world, lagged, end, state.known->curvature, found)) {
    found.tip = state.tip;
    found.there = Potential(world, lagged, state.tip);
  }
  if (holds_still)
    found.converged = true;
  else if (!found.converged)
    minimise(world, lagged, found);
  result.iterations += found.iterations;
  // Sliding off an edge ends on it, where one surface stops and the next is not looked at yet.
  for (int turn = 0; turn < kMostTurns && !found.converged; ++turn) {
    lagged = lag_again(world, state, lagged, found.tip.full());
    const int before = found.iterations;
    found.iterations = 0;
    found.there = Potential(world, lagged, found.tip);
    minimise(world, lagged, found);
    result.iterations += found.iterations;
    if (found.iterations == 0 && before == 0) break;
  }
  const Contacts now = contacts(world, lagged, found.tip, found.there);
  const auto to_halve = [&]() noexcept {
    const Pose move = command - state.hand;
    const double travel = move.head<3>().norm() +
                          move.tail<2>().norm() * (lagged.length + world.annulus.fibre_radius);
    const bool search = !found.converged && depth < kMostHalvings && travel > 0;
    const bool locate = depth < kMostEventHalvings && travel > world.event_travel &&
                        is_event(state, now, lagged.contact.side, found.tip.full(), travel);
    return search || locate;
  };
  if ((!found.converged || std::isfinite(world.event_travel)) && to_halve()) {
    ++result.halvings;
    const Pose half = state.hand + 0.5 * (command - state.hand);
    advance(world, half, 0.5 * dt, depth + 1, result);
    advance(world, command, 0.5 * dt, depth + 1, result);
    return;
  }
  if (!found.converged) result.status = StepStatus::not_converged;
  const Pose tip = found.tip.full();
  update_velocity(lagged, tip, dt, state);
  state.tip = tip;
  state.hand = command;
  state.side = lagged.contact.side;
  update_contacts(lagged, now, state);
  state.bridge = now.bridge;
  const Energy& bore = found.there.bore;
  state.known.emplace(tip, bore.gradient, bore.hessian, found.curvature);
  if (result.substeps > 0) result.forces = {};
  forces(world, lagged, found.tip, found.there, result.forces);
  ++result.substeps;
}

// Free flight: the end hangs on the holder.
StepResult hang(const World& world, const State& state, const Pose& hand, double dt) noexcept {
  StepResult result;
  State& now = result.state;
  now.tip = hand + world.holder.sag;
  now.hand = hand;
  now.time = state.time + dt;
  now.side = state.side;
  now.velocity = state.velocity;
  now.tip_before = state.tip_before;
  now.velocity_before = state.velocity_before;
  now.dt_before = state.dt_before;
  result.forces.holder = world.holder.weight;
  result.forces.gravity = {{0, world.holder.weight[1], 0},
                           now.tip.head<3>() + world.holder.weight_arm};
  result.substeps = 1;
  return result;
}

// Near the ferrule, or with inertia: in sub-steps to the command.
StepResult follow_hand(const World& world, const State& state, const Pose& hand,
                       double dt) noexcept {
  StepResult result(state);
  result.state.time = state.time + dt;
  const Pose& from = state.hand;
  const int parts = substeps_for(world, state, hand, dt);
  const double part = dt / parts;
  for (int k = 1; k < parts; ++k)
    advance(world, from + static_cast<double>(k) / parts * (hand - from), part, 0, result);
  advance(world, hand, part, 0, result);
  return result;
}

// Nothing to do: the state is unchanged, and so are the forces.
StepResult refuse(const World& world, const State& state) noexcept {
  StepResult result(state);
  result.status = StepStatus::bad_command;
  const Lagged lagged = lag(world, state, state.hand, 0);
  forces(world, lagged, state.tip, Potential(world, lagged, state.tip), result.forces);
  return result;
}

}  // namespace

StepResult step(const World& world, const State& state, const Pose& hand, double dt) noexcept {
  if (!hand.allFinite() || !std::isfinite(dt) || dt < 0) return refuse(world, state);
  if (flies_free(world, state, hand)) return hang(world, state, hand, dt);
  return follow_hand(world, state, hand, dt);
}

}  // namespace ferrule
