#include "sim/step.hpp"

#include <algorithm>
#include <cmath>

#include "sim/event_search.hpp"
#include "sim/free_flight.hpp"
#include "sim/sub_step.hpp"
#include "sim/tangent.hpp"

namespace ferrule {
namespace {

constexpr int kMostParts = 8192;     // of the longest steps that the world allows
constexpr int kMostAtOnce = 12;      // sub-steps that a long way is divided into before it is tried
constexpr int kFewEvaluations = 5;   // of a sub-step that may still be shortened
constexpr int kReserve = 24;         // evaluations that are kept for the way to the command
constexpr double kEdgeStep = 0.05;   // of the rim's radius, where it slides over an edge
constexpr double kNearEdge = 0.5;    // and before and behind
constexpr double kMostDivided = 64;  // the shortest sub-step of a way is that part of it
constexpr double kTurnedBy = 0.02;   // squared sine of the angle that a contact may turn by

// Contacts after a step that has moved the end: new ones stick where they are, slipping ones drag
// their stuck point along. Where a contact moves on over the fibre it is another material point's,
// and the spring is as stretched as before. A spot that grows is not sheared where it is new: the
// force stays and the stretch becomes less; one that shrinks gives up its part of the force
// (Mindlin and Deresiewicz, 1953). So no energy is gained.
void update_contacts(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                     const Potential& there, const Contacts& now, State& state) noexcept {
  if (!now.contact[kEnd].closed && !now.contact[kSide].closed) {
    state.contact = now.contact;
    return;
  }
  const ContactSide side = contact_side(world, state);
  for (int place = 0; place < kContactPlaces; ++place) {
    ContactState& contact = state.contact[place];
    const bool was_closed = contact.closed;
    contact = now.contact[place];
    if (!contact.closed) continue;
    contact.stuck = material_point(world, side, place, tip);
    const FrozenFriction& friction = frozen.friction[place];
    if (!was_closed || !friction.acts) continue;
    const Vector3d stretched = stretch(world, frozen, place, tip);
    const double length = stretched.norm(), allowed = friction.limit / friction.stiffness;
    const double stiffness = stuck_stiffness(world, frozen, tip, there, place);
    double part = length > allowed ? allowed / length : 1;
    if (stiffness > friction.stiffness) part *= friction.stiffness / stiffness;
    contact.stuck -= part * stretched;
  }
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

// How many of the world's longest steps a step is.
int parts_of(const World& world, double dt) noexcept {
  if (!(dt > world.numerics.longest_step)) return 1;
  return static_cast<int>(
      std::clamp<double>(std::ceil(dt / world.numerics.longest_step * (1 - 1e-9)), 1, kMostParts));
}

// How far the command travels [m], at the end or at the other end of the inserted length.
double travel_of(const World& world, const State& state, const Pose& command) noexcept {
  const PoseVector move = PoseVector(command) - state.command;
  return move.length() + (state.inserted_length() + world.annulus.fibre_radius) * move.t.norm();
}

// The part of the way to `command` to be tried first: half a clearance where something may be on
// the way, but not too many of them.
double first_part(const World& world, const State& state, const Pose& command) noexcept {
  const double travel = travel_of(world, state, command), clearance = world.annulus.clearance();
  if (travel <= 0.5 * clearance) return 1;
  // Clear of the ferrule before and after: nothing on the way.
  const double lever = state.inserted_length() + world.annulus.fibre_radius;
  const double nearest =
      std::min({state.tip[0], state.command[0], command[0]}) -
      lever * (state.tip.tail<2>().norm() + command.tail<2>().norm() + world.end.cleave.norm());
  if (nearest > world.profile.lead_in_length + clearance) return 1;
  return std::max(0.5 * clearance / travel, 1.0 / kMostAtOnce);
}

// What the rim slides over an edge in [m].
double edge_step(const World& world) noexcept {
  return kEdgeStep * world.end.rounding();
}

// The part of a way along x to be taken at most where the end rubs near the edge between bore and
// cone: up to where its rim goes round that, and there in short parts, as friction and adhesion
// turn.
double part_to_edge(const World& world, const State& state, double way) noexcept {
  const double tangent = world.profile.lead_in_tangent;
  if (!state.contact[kEnd].closed || state.side == EdgeSide::face || !(tangent > 0))
    return INFINITY;
  const PoseVector tip(state.tip);
  const double out = tip.e.norm() > 0 ? tip.e.dot(tip.t + world.end.cleave) / tip.e.norm() : 0.0;
  const double rho = world.end.rounding(), near = kNearEdge * rho;
  const double turning = rho * tangent * world.profile.lead_in_cosine();
  const double rim = tip.x + world.end.edge - world.annulus.fibre_radius * out;
  const double left = near + (way > 0 ? turning - rim : rim);
  if (left < 0) return INFINITY;
  return std::max(edge_step(world), left - turning - 2 * near) / std::abs(way);
}

// Did something begin or end, did a contact that rubs turn, as over an edge, did the end leave the
// face, or did it move by far more than the command?
bool is_event(const World& world, const State& before, const FrozenCoefficients& frozen,
              const Minimum& found, const Contacts& now, double travel) noexcept {
  if (hits(before, now)) return true;
  for (std::size_t place = 0; place < kContactPlaces; ++place) {
    const FrozenFriction& friction = frozen.friction[place];
    if (!friction.acts || !now.contact[place].closed) continue;
    const Vector3d normal = found.there.depth[place].normal(found.tip.t);
    if (normal.dot(friction.tangential * normal) > kTurnedBy * normal.squaredNorm()) return true;
  }
  const EdgeSide side = frozen.contact.side;
  return before.side != side || side_of(world, found.tip, side) != side ||
         (found.tip.position() - before.tip.head<3>()).norm() > kSnap * travel;
}

// Takes the minimum as the state after the sub-step. Forces and tangent are those of the `last`.
void accept(const World& world, const Pose& command, double dt, const FrozenCoefficients& frozen,
            const Minimum& found, const Contacts& now, bool last, StepResult& result) noexcept {
  State& state = result.state;
  const Pose tip = found.tip.full();
  update_velocity(frozen, tip, dt, state);
  // A velocity that jumps is not extrapolated.
  if (frozen.inertial && hits(state, now)) state.dt_before = 0;
  state.tip = tip;
  state.command = command;
  state.side = frozen.contact.side;
  update_contacts(world, frozen, found.tip, found.there, now, state);
  state.bridge = now.bridge;
  state.air = tip[0] < 0 ? frozen.flow.air_at(-tip[0]) : 0;
  const Energy& bore = found.there.bore;
  state.linearization = Linearization{tip, bore.gradient, bore.hessian, found.curvature};
  ++result.substeps;
  if (!last) return;
  result.forces = {};
  forces(world, frozen, found.tip, found.there, result.forces);
  set_tangent(world, frozen, found, dt, state);
}

// A sub-step: taken or, where it was too long, not: the minimum is far, or something happens in it.
struct Advance {
  bool taken;
  bool event;          // something has happened
  double where = NAN;  // about this part of it, where it was not taken
};

// Where a sub-step may be given up, to be divided. Over an edge, where much turns and a search
// needs more evaluations, only where the end has come off.
enum class Divisible { no, where_end_comes_off, at_events };

// One from result.state to `command`, of at most so many evaluations; the `last` of a way.
Advance advance(const World& world, const Pose& command, double dt, bool last, int most_evaluations,
                Divisible may_be, StepResult& result) noexcept {
  const bool divisible = may_be == Divisible::at_events;
  const State& state = result.state;
  double where = NAN;
  FrozenCoefficients frozen = freeze(world, state, command, dt);
  const int most = most_evaluations - 2;  // two may be needed to stay
  const int few = divisible ? std::min(kFewEvaluations, most) : most;
  Minimum found = solve_sub_step(world, state, dt, few, most, divisible ? &where : nullptr, frozen);
  if (!divisible) stay_if_astray(world, state, command, dt, most_evaluations, frozen, found);
  const bool spent = found.evaluations >= most;
  result.evaluations += found.evaluations;
  result.iterations += found.iterations;
  if (divisible && !found.converged) return {false, true, where};
  const Contacts now = contacts(world, frozen, found.tip, found.there);
  const bool event = is_event(world, state, frozen, found, now, travel_of(world, state, command));
  if (divisible && event) return {false, true, where};
  const bool came_off = state.contact[kEnd].closed && !now.contact[kEnd].closed;
  if (may_be == Divisible::where_end_comes_off && came_off) return {false, true};
  result.status = found.converged ? StepStatus::ok
                  : spent         ? StepStatus::capped
                                  : StepStatus::not_converged;
  accept(world, command, dt, frozen, found, now, last, result);
  return {true, event};
}

// The linearization's curvature is that of a way as long as the one before; `part` of that.
void shorten_curvature(double part, State& state) noexcept {
  if (!(part < 1) || !state.linearization) return;
  PoseVector& curvature = state.linearization->curvature;
  curvature = part * part * curvature;
}

// To `command` over dt in sub-steps, as long as nothing happens and short where it does, of at most
// kMostEvaluations together.
void follow_part(const World& world, const Pose& command, double dt, StepResult& result) noexcept {
  const int end = result.evaluations + kMostEvaluations;
  const Pose from = result.state.command;
  const double travel = travel_of(world, result.state, command);
  const double shortest = std::max(world.numerics.event_travel, travel / kMostDivided);
  const double first = first_part(world, result.state, command);
  EventSearch search(shortest / travel);
  for (double tried = NAN; search.done() < 1;) {
    const double done = search.done();
    const double edge = part_to_edge(world, result.state, command[0] - from[0]);
    double to = search.bounded() ? search.next() : done + std::min(first, edge);
    const int left = end - result.evaluations;
    const bool enough = left > kReserve + kFewEvaluations;
    const bool last = !enough || to > 1 - 1e-9;
    if (last) to = 1;
    const double way = (to - done) * travel;
    const bool over_edge = !search.bounded() && edge < first && way <= 1.01 * edge_step(world);
    Divisible divisible = Divisible::no;
    if (enough && (search.bounded() ? search.divisible(to) : way > shortest))
      divisible = over_edge ? Divisible::where_end_comes_off : Divisible::at_events;
    shorten_curvature((to - done) / tried, result.state);
    tried = std::fmin(tried, to - done);
    const Pose goal = last ? command : Pose(from + to * (command - from));
    const Advance went = advance(world, goal, (to - done) * dt, last, last ? left : left - kReserve,
                                 divisible, result);
    if (went.taken) {
      search.take(world, result.state, to, went.event);
    } else {
      search.give_up(world, result.state, to, went.where);
      ++result.halvings;
    }
  }
}

// Near the ferrule, or with inertia: in no longer steps than the world allows, from the `state`
// that `result` has.
void follow_command(const World& world, const State& state, const Pose& command, double dt,
                    StepResult& result) noexcept {
  result.status = StepStatus::ok;
  result.evaluations = result.iterations = result.substeps = result.halvings = 0;
  result.state.time = state.time + dt;
  leave_tangent(world, result.state);
  const int parts = parts_of(world, dt);
  for (int k = 1; k <= parts; ++k)
    follow_part(world,
                k == parts ? command
                           : Pose(state.command +
                                  static_cast<double>(k) / parts * (command - state.command)),
                dt / parts, result);
  set_reach(world, state, result);
}

// Nothing to do: the state is unchanged, and so are the forces.
StepResult refuse(const World& world, const State& state) noexcept {
  StepResult result(state);
  result.status = StepStatus::bad_command;
  const FrozenCoefficients frozen = freeze(world, state, state.command, 0);
  forces(world, frozen, state.tip, Potential(world, frozen, state.tip), result.forces);
  return result;
}

// A step that needs no potential: refused, along a tangent, or free. False: it is to be solved.
bool step_unsolved(const World& world, const Pose& command, double dt, StepResult& now) noexcept {
  const bool finite = (0 * command).sum() == 0;
  if (!finite || !(dt >= 0 && dt < INFINITY)) {
    now = refuse(world, now.state);
    return true;
  }
  if (now.state.tangent)
    if (const auto next = along_tangent(world, now.state, command, dt)) {
      follow_tangent(world, command, dt, *next, now);
      return true;
    }
  return fly_free(world, command, dt, now);
}

}  // namespace

Breakdown all_forces(const World& world, const StepResult& now) noexcept {
  if (now.evaluations > 0 || !now.state.tangent) return now.forces;
  const State before = before_tangent_step(world, now.state);
  StepResult solved(before);
  follow_command(world, before, now.state.command, now.state.tangent->dt, solved);
  solved.forces.holder = now.forces.holder;
  return solved.forces;
}

StepResult step(const World& world, const State& state, const Pose& command, double dt) noexcept {
  StepResult result(state);
  if (step_unsolved(world, command, dt, result))
    result.forces = all_forces(world, result);
  else
    follow_command(world, state, command, dt, result);
  return result;
}

void step_on(const World& world, const Pose& command, double dt, StepResult& now) noexcept {
  if (step_unsolved(world, command, dt, now)) return;
  const State state = now.state;
  follow_command(world, state, command, dt, now);
}

}  // namespace ferrule
