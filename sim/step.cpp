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
constexpr double kShortMove = 0.1;        // of the clearance: as far as a prediction reaches
constexpr double kLargestMiss = 0.3;      // of the gradient, that a prediction may leave there

// A search for the minimum: where it has got to.
struct Minimum {
  Minimum(const World& world, const FrozenCoefficients& frozen, const PoseVector& start) noexcept
      : tip(start), there(world, frozen, start) {}

  PoseVector tip;
  Potential there;
  PoseVector curvature = {};  // Linearization::curvature
  int iterations = 0, evaluations = 1;
  bool converged = false;
};

// Residual of a gradient [N], tilts weighed by the length that makes both stiffnesses equal.
double residual(const World& world, const PoseVector& gradient) noexcept {
  return std::max({std::abs(gradient.x), gradient.e.cwiseAbs().maxCoeff(),
                   gradient.t.cwiseAbs().maxCoeff() / world.holder.tilt_length});
}

// How far a move takes the end or the other end of the inserted length [m].
double travel_of(const World& world, const FrozenCoefficients& frozen,
                 const PoseVector& move) noexcept {
  return move.length() + move.t.norm() * (frozen.length + world.annulus.fibre_radius);
}

// The last Newton step, where it is so short that the forces change along it as the Hessian says
// and need no evaluation; false where it is not.
bool final_newton_step(const World& world, const FrozenCoefficients& frozen, const PoseVector& rest,
                       Minimum& found) noexcept {
  Potential& there = found.there;
  if (!(residual(world, there.gradient) <= kNearForce * there.force_scale &&
        travel_of(world, frozen, rest) <= kNearMove * world.annulus.clearance()))
    return false;
  found.tip += rest;
  there.bore.gradient += there.bore.hessian.times(rest);
  found.converged = true;
  return true;
}

// Newton's method with a line search, from where `found` is.
void minimise(const World& world, const FrozenCoefficients& frozen, Minimum& found) noexcept {
  const double clearance = world.annulus.clearance();
  const double radius = world.annulus.fibre_radius, lever = frozen.length + radius;
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
    if (found.iterations >= kPatience && final_newton_step(world, frozen, newton, found)) break;
    // Far from everything the potential is a quadratic and any length is right; among surface
    // forces a step longer than the clearance tells nothing.
    const double reach = std::max(newton.e.norm(), turn);
    double fraction = frozen.length > 0 && reach > clearance ? clearance / reach : 1;
    const double slope = here.gradient.dot(newton);
    bool moved = false;
    for (int halving = 0; halving < kMaxHalvings; ++halving, fraction *= 0.5) {
      PoseVector trial = found.tip;
      trial += fraction * newton;
      const Potential there(world, frozen, trial);
      ++found.evaluations;
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

// Where the linearization of the last step says that this one ends.
struct Prediction {
  bool valid = false;
  PoseVector tip;
  Eliminated hessian;
  PoseVector move = {};
  double slope = 0;  // of the energy along the move, < 0
};

// The predictor: a Newton step from the linearization, without an evaluation of the potential.
Prediction predict(const World& world, const FrozenCoefficients& frozen,
                   const State& state) noexcept {
  Prediction end;
  end.tip = state.tip;
  if (!state.linearization || state.linearization->at != state.tip) return end;
  Energy here = potential_at_start(world, frozen, *state.linearization);
  here.gradient += state.linearization->curvature;
  if (!end.hessian.of(here.hessian)) return end;
  end.move = end.hessian.solve(here.gradient);
  end.slope = end.move.dot(here.gradient);
  const double way = travel_of(world, frozen, end.move);
  if (!(end.slope < 0 && way >= kResolution && way <= kShortMove * world.annulus.clearance()))
    return end;
  end.tip += end.move;
  end.valid = true;
  return end;
}

// The corrector: goes on from the prediction, evaluated there. False where the prediction is too
// far from a minimum.
bool correct(const World& world, const FrozenCoefficients& frozen, const Prediction& end,
             const PoseVector& curvature, Minimum& found) noexcept {
  const Potential& there = found.there;
  if (!(std::abs(end.move.dot(there.gradient)) <= -kLargestMiss * end.slope)) return false;
  found.iterations = 1;
  found.curvature = curvature;
  found.curvature += there.gradient;
  if (residual(world, there.gradient) <= kNearForce * there.force_scale)
    final_newton_step(world, frozen, end.hessian.solve(there.gradient), found);
  return true;
}

// Contacts after a step: new ones stick where they are, slipping ones drag their stuck point along.
void update_contacts(const FrozenCoefficients& frozen, const Contacts& now, State& state) noexcept {
  for (int place = 0; place < kContactPlaces; ++place) {
    ContactState& contact = state.contact[place];
    const bool was_closed = contact.closed;
    const Vector3d stuck = contact.stuck;
    contact = now.contact[place];
    if (!contact.closed) continue;
    const FrozenFriction& friction = frozen.friction[place];
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

// The frozen quantities once more, where the end has got to; time still runs from the step's start.
FrozenCoefficients freeze_again(const World& world, const State& start,
                                const FrozenCoefficients& first, const Pose& tip) noexcept {
  State there = start;
  there.tip = tip;
  there.side = first.contact.side;
  const FrozenCoefficients now = freeze(world, there, first.command.full(), 0);
  FrozenCoefficients again = first;
  again.length = now.length;
  again.contact = now.contact;
  again.friction = now.friction;
  return again;
}

// Velocities after a step that ends at `tip`, by the rule that the step used.
void update_velocity(const FrozenCoefficients& frozen, const Pose& tip, double dt,
                     State& state) noexcept {
  if (!frozen.inertial) return;
  const Pose velocity = frozen.second_order
                            ? Pose((3 * tip - 4 * state.tip + state.tip_before) / (2 * dt))
                            : Pose((tip - state.tip) / dt);
  state.velocity_before = state.velocity;
  state.tip_before = state.tip;
  state.velocity = velocity;
  state.dt_before = dt;
}

// Nothing near the fibre now or where it is commanded to, and no inertia: it hangs on the holder
// alone.
bool flies_free(const World& world, const State& state, const Pose& command) noexcept {
  if (world.dynamics == Dynamics::inertial) return false;
  const double reach = world.profile.lead_in_length + world.annulus.clearance();
  if (!(std::min(state.tip[0], state.command[0]) > reach)) return false;
  const double lever = world.annulus.fibre_radius;
  const Pose goal = command + world.holder.sag;
  const auto tilt = [](const Pose& p) { return std::abs(p[3]) + std::abs(p[4]); };
  return std::min({state.tip[0], state.command[0], goal[0]}) -
             lever * (tilt(state.tip) + tilt(goal)) >
         reach;
}

int substeps_for(const World& world, const State& state, const Pose& command, double dt) noexcept {
  int fewest = 1;
  if (dt > world.numerics.longest_step)
    fewest = static_cast<int>(std::clamp<double>(
        std::ceil(dt / world.numerics.longest_step * (1 - 1e-9)), 1, kMaxSubsteps));
  const PoseVector move = PoseVector(command) - state.command;
  const double clearance = world.annulus.clearance();
  const double lever = state.inserted_length() + world.annulus.fibre_radius;
  const double travel = move.length() + lever * move.t.norm();
  if (travel <= 0.5 * clearance) return fewest;
  // Clear of the ferrule before and after: nothing on the way.
  const double nearest = std::min({state.tip[0], state.command[0], command[0]}) -
                         lever * (state.tip.tail<2>().norm() + command.tail<2>().norm());
  if (nearest > world.profile.lead_in_length + clearance) return fewest;
  return std::max(
      fewest, static_cast<int>(std::min<double>(std::ceil(2 * travel / clearance), kMaxSubsteps)));
}

// Did something begin or end, or did the end move by far more than the command?
bool is_event(const State& before, const Contacts& now, EdgeSide side, const Pose& tip,
              double travel) noexcept {
  for (std::size_t place = 0; place < kContactPlaces; ++place)
    if (before.contact[place].closed != now.contact[place].closed ||
        before.contact[place].branch != now.contact[place].branch)
      return true;
  return before.bridge != now.bridge || before.side != side ||
         (tip - before.tip).head<3>().norm() > 10 * travel;
}

// Finds the minimum of a sub-step: predictor, corrector, and Newton's method where they do not
// suffice. Freezes the coefficients again where the end slides off an edge.
Minimum solve(const World& world, const State& state, double dt, FrozenCoefficients& frozen,
              StepResult& result) noexcept {
  const bool holds_still = world.dynamics == Dynamics::inertial && dt == 0;
  const Prediction end =
      holds_still ? Prediction{false, state.tip, {}} : predict(world, frozen, state);
  Minimum found(world, frozen, end.tip);
  if (end.valid && !correct(world, frozen, end, state.linearization->curvature, found)) {
    found.tip = state.tip;
    found.there = Potential(world, frozen, state.tip);
    ++found.evaluations;
  }
  if (holds_still)
    found.converged = true;
  else if (!found.converged)
    minimise(world, frozen, found);
  result.iterations += found.iterations;
  // Sliding off an edge ends on it, where one surface stops and the next is not looked at yet.
  for (int turn = 0; turn < kMostTurns && !found.converged; ++turn) {
    frozen = freeze_again(world, state, frozen, found.tip.full());
    const int before = found.iterations;
    found.iterations = 0;
    found.there = Potential(world, frozen, found.tip);
    ++found.evaluations;
    minimise(world, frozen, found);
    result.iterations += found.iterations;
    if (found.iterations == 0 && before == 0) break;
  }
  result.evaluations += found.evaluations;
  return found;
}

// Is the sub-step to be halved: because the minimum was not found, or to locate an event?
bool must_halve(const World& world, const State& state, const Pose& command,
                const FrozenCoefficients& frozen, const Minimum& found, const Contacts& now,
                int depth) noexcept {
  const double event_travel = world.numerics.event_travel;
  if (found.converged && !std::isfinite(event_travel)) return false;
  const Pose move = command - state.command;
  const double travel =
      move.head<3>().norm() + move.tail<2>().norm() * (frozen.length + world.annulus.fibre_radius);
  const bool search = !found.converged && depth < kMostHalvings && travel > 0;
  const bool locate = depth < kMostEventHalvings && travel > event_travel &&
                      is_event(state, now, frozen.contact.side, found.tip.full(), travel);
  return search || locate;
}

// Takes the minimum as the state after the sub-step.
void accept(const World& world, const Pose& command, double dt, const FrozenCoefficients& frozen,
            const Minimum& found, const Contacts& now, StepResult& result) noexcept {
  State& state = result.state;
  if (!found.converged) result.status = StepStatus::not_converged;
  const Pose tip = found.tip.full();
  update_velocity(frozen, tip, dt, state);
  state.tip = tip;
  state.command = command;
  state.side = frozen.contact.side;
  update_contacts(frozen, now, state);
  state.bridge = now.bridge;
  const Energy& bore = found.there.bore;
  state.linearization = Linearization{tip, bore.gradient, bore.hessian, found.curvature};
  if (result.substeps > 0) result.forces = {};
  forces(world, frozen, found.tip, found.there, result.forces);
  ++result.substeps;
}

// One sub-step from result.state to `command`: freeze, solve, accept; halved where it must be.
void advance(const World& world, const Pose& command, double dt, int depth,
             StepResult& result) noexcept {
  const State& state = result.state;
  FrozenCoefficients frozen = freeze(world, state, command, dt);
  const Minimum found = solve(world, state, dt, frozen, result);
  const Contacts now = contacts(world, frozen, found.tip, found.there);
  if (must_halve(world, state, command, frozen, found, now, depth)) {
    ++result.halvings;
    const Pose half = state.command + 0.5 * (command - state.command);
    advance(world, half, 0.5 * dt, depth + 1, result);
    advance(world, command, 0.5 * dt, depth + 1, result);
    return;
  }
  accept(world, command, dt, frozen, found, now, result);
}

// Free flight: the end hangs on the holder.
StepResult hang(const World& world, const State& state, const Pose& command, double dt) noexcept {
  StepResult result;
  State& now = result.state;
  now.tip = command + world.holder.sag;
  now.command = command;
  now.time = state.time + dt;
  now.side = state.side;
  now.velocity = state.velocity;
  now.tip_before = state.tip_before;
  now.velocity_before = state.velocity_before;
  now.dt_before = state.dt_before;
  result.forces.holder = world.holder.weight;
  result.forces[Term::gravity][0] = {{0, world.holder.weight[1], 0},
                                     now.tip.head<3>() + world.holder.weight_arm};
  result.substeps = 1;
  return result;
}

// Near the ferrule, or with inertia: in sub-steps to the command.
StepResult follow_command(const World& world, const State& state, const Pose& command,
                          double dt) noexcept {
  StepResult result(state);
  result.state.time = state.time + dt;
  const Pose& from = state.command;
  const int parts = substeps_for(world, state, command, dt);
  const double part = dt / parts;
  for (int k = 1; k < parts; ++k)
    advance(world, from + static_cast<double>(k) / parts * (command - from), part, 0, result);
  advance(world, command, part, 0, result);
  return result;
}

// Nothing to do: the state is unchanged, and so are the forces.
StepResult refuse(const World& world, const State& state) noexcept {
  StepResult result(state);
  result.status = StepStatus::bad_command;
  const FrozenCoefficients frozen = freeze(world, state, state.command, 0);
  forces(world, frozen, state.tip, Potential(world, frozen, state.tip), result.forces);
  return result;
}

}  // namespace

StepResult step(const World& world, const State& state, const Pose& command, double dt) noexcept {
  if (!command.allFinite() || !std::isfinite(dt) || dt < 0) return refuse(world, state);
  if (flies_free(world, state, command)) return hang(world, state, command, dt);
  return follow_command(world, state, command, dt);
}

}  // namespace ferrule
