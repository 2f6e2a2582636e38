#include "sim/step.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "sim/potential.hpp"

namespace ferrule {
namespace {

constexpr int kMaxIterations = 200;
constexpr int kMaxHalvings = 50;
constexpr int kMaxSubsteps = 8192;
constexpr int kMostTurns = 4;             // at edges, in one sub-step
constexpr double kForceTolerance = 1e-9;  // relative to the sum of all force magnitudes
constexpr double kForceFloor = 1e-14;     // [N]
constexpr double kResolution = 1e-15;     // a Newton step shorter than this is none [m]

struct Minimum {
  Pose tip;
  Forces forces;  // there
  int iterations = 0;
  bool converged = false;
};

// Residual of a gradient [N], tilts weighed by the length that makes both stiffnesses equal.
double residual(const World& world, const Pose& gradient) noexcept {
  return std::max(gradient.head<3>().cwiseAbs().maxCoeff(),
                  gradient.tail<2>().cwiseAbs().maxCoeff() / world.holder.tilt_length);
}

// The Newton direction; where the Hessian is not positive definite it is shifted by multiples of
// the holder's stiffness until it is.
Pose newton_direction(const World& world, const Potential& here) noexcept {
  double factor = 0;
  for (int attempt = 0; attempt < 80; ++attempt) {
    Matrix5 hessian = here.hessian;
    if (factor > 0) hessian += factor * world.holder.stiffness;
    const Eigen::LLT<Matrix5> cholesky(hessian);
    if (cholesky.info() == Eigen::Success) {
      const Pose direction = -cholesky.solve(here.gradient);
      if (direction.allFinite() && direction.dot(here.gradient) < 0) return direction;
    }
    factor = factor == 0 ? 1 : 4 * factor;
  }
  return -here.gradient.cwiseQuotient(world.holder.stiffness.diagonal());
}

Minimum minimise(const World& world, const Lagged& lagged, const Pose& hand,
                 const Pose& start) noexcept {
  Minimum found;
  found.tip = start;
  const double clearance = world.annulus.clearance();
  const double lever = lagged.length + world.annulus.fibre_radius;
  Potential here = potential(world, lagged, hand, found.tip);
  Forces trial_forces;
  bool known = false;  // found.forces are those at found.tip
  for (; found.iterations < kMaxIterations; ++found.iterations) {
    const double tolerance = kForceFloor + kForceTolerance * here.force_scale;
    if (residual(world, here.gradient) <= tolerance) {
      found.converged = true;
      break;
    }
    Pose direction = newton_direction(world, here);
    if (direction.head<3>().norm() + direction.tail<2>().norm() * lever < kResolution) {
      found.converged = true;
      break;
    }
    // Far from everything the potential is a quadratic and any length is right; among surface
    // forces a step longer than the clearance tells nothing.
    const double reach =
        std::max(direction.segment<2>(1).norm(), direction.tail<2>().norm() * lever);
    if (lagged.length > 0 && reach > clearance) direction *= clearance / reach;

    const double slope = here.gradient.dot(direction);
    bool moved = false;
    double fraction = 1;
    for (int halving = 0; halving < kMaxHalvings; ++halving, fraction *= 0.5) {
      const Pose trial = found.tip + fraction * direction;
      const Potential there = potential(world, lagged, hand, trial, &trial_forces);
      // Where the drop drowns in rounding, a smaller residual decides.
      const double rounding =
          1e-15 * (here.value_scale + here.force_scale * found.tip.head<3>().norm());
      const bool lower = there.value <= here.value + 1e-4 * fraction * slope;
      const bool level = there.value <= here.value + rounding &&
                         residual(world, there.gradient) < residual(world, here.gradient);
      if (lower || level) {
        moved = (trial.array() != found.tip.array()).any();
        found.tip = trial;
        here = there;
        found.forces = trial_forces;
        break;
      }
    }
    if (!moved) break;
    known = true;
  }
  if (!known) potential(world, lagged, hand, found.tip, &found.forces);
  return found;
}

// Contacts after a step: new ones stick where they are, slipping ones drag their stuck point along.
void update_contacts(const Lagged& lagged, const Forces& now, State& state) noexcept {
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
  Lagged again = lag(world, there, 0);
  again.drags = first.drags;
  again.drag_from = first.drag_from;
  again.drag_coefficients = first.drag_coefficients;
  again.drag_arm = first.drag_arm;
  again.dt = first.dt;
  again.inertial = first.inertial;
  again.second_order = first.second_order;
  again.inertia = first.inertia;
  again.inertia_at = first.inertia_at;
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
  const double lever = world.annulus.fibre_radius;
  const Pose goal = hand + world.holder.sag;
  return std::min({state.tip[0], state.hand[0], goal[0]}) -
             lever * (state.tip.tail<2>().cwiseAbs().sum() + goal.tail<2>().cwiseAbs().sum()) >
         reach;
}

int substeps_for(const World& world, const State& state, const Pose& hand) noexcept {
  const Pose move = hand - state.hand;
  const double clearance = world.annulus.clearance();
  const double lever = state.inserted_length() + world.annulus.fibre_radius;
  const double travel = move.head<3>().norm() + lever * move.tail<2>().norm();
  if (travel <= 0.5 * clearance) return 1;
  // Clear of the ferrule before and after: nothing on the way.
  const double nearest = std::min({state.tip[0], state.hand[0], hand[0]}) -
                         lever * (state.tip.tail<2>().norm() + hand.tail<2>().norm());
  if (nearest > world.profile.lead_in_length + clearance) return 1;
  return static_cast<int>(std::min<double>(std::ceil(2 * travel / clearance), kMaxSubsteps));
}

}  // namespace

StepResult step(const World& world, const State& state, const Pose& hand, double dt) noexcept {
  StepResult result;
  result.state = state;
  if (!hand.allFinite() || !std::isfinite(dt) || dt < 0) {
    result.status = StepStatus::bad_command;
    Forces forces;
    potential(world, lag(world, state, 0), state.hand, state.tip, &forces);
    result.forces = forces.breakdown;
    return result;
  }
  if (flies_free(world, state, hand)) {
    result.state.tip = hand + world.holder.sag;
    result.state.hand = hand;
    result.state.time = state.time + dt;
    result.state.bridge = false;
    result.state.contact = {};
    result.forces.holder = world.holder.weight;
    result.forces.gravity = {{0, world.holder.weight[1], 0},
                             result.state.tip.head<3>() + world.holder.weight_arm};
    result.substeps = 1;
    return result;
  }
  const Pose from = state.hand;
  result.substeps = substeps_for(world, state, hand);
  const double part_dt = dt / result.substeps;
  for (int k = 1; k <= result.substeps; ++k) {
    const double part = static_cast<double>(k) / result.substeps;
    const Pose command = k == result.substeps ? hand : Pose(from + part * (hand - from));
    Lagged lagged = lag(world, result.state, part_dt);
    const bool holds_still = world.dynamics == Dynamics::inertial && part_dt == 0;
    Minimum found;
    if (holds_still) {
      found.tip = result.state.tip;
      found.converged = true;
      potential(world, lagged, command, found.tip, &found.forces);
    } else {
      found = minimise(world, lagged, command, result.state.tip);
    }
    result.iterations += found.iterations;
    // Sliding off an edge ends on it, where one surface stops and the next is not looked at yet.
    for (int turn = 0; turn < kMostTurns && !found.converged; ++turn) {
      lagged = lag_again(world, result.state, lagged, found.tip);
      const int before = found.iterations;
      found = minimise(world, lagged, command, found.tip);
      result.iterations += found.iterations;
      if (found.iterations == 0 && before == 0) break;
    }
    if (!found.converged) result.status = StepStatus::not_converged;
    update_velocity(lagged, found.tip, part_dt, result.state);
    result.state.tip = found.tip;
    result.state.hand = command;
    result.state.side = lagged.contact.side;
    const Forces& now = found.forces;
    update_contacts(lagged, now, result.state);
    result.state.bridge = now.bridge;
    result.forces = now.breakdown;
  }
  result.state.time = state.time + dt;
  return result;
}

}  // namespace ferrule
