#include "sim/solver/step.hpp"

#include <algorithm>
#include <cmath>

#include "sim/solver/events.hpp"
#include "sim/solver/extrapolation.hpp"
#include "sim/solver/free_flight.hpp"
#include "sim/solver/sub_step.hpp"
#include "sim/terms/contact.hpp"

namespace ferrule {
namespace {

constexpr int kMaxParts = 8192;     // of the longest steps that the world allows
constexpr double kFirstParts = 12;  // sub-steps of a long path, before events divide it
constexpr double kEdgeStep = 0.05;  // of the rim's radius, where it slides over an edge
constexpr double kNearEdge = 0.5;   // and so far before and behind the edge, of the same

// --- Where the path to the command is divided ---

// How many of the world's longest steps a step is.
int parts_of(const World& world, double dt) noexcept {
  if (!(dt > world.numerics.longest_step)) return 1;
  return static_cast<int>(
      std::clamp<double>(std::ceil(dt / world.numerics.longest_step * (1 - 1e-9)), 1, kMaxParts));
}

// How far the command moves [m], at the end or at the other end of the inserted length.
double command_travel(const World& world, const State& state, const Pose& command) noexcept {
  const PoseVector move = PoseVector(command) - state.command;
  return move.length() + (state.inserted_length() + world.annulus.fibre_radius) * move.t.norm();
}

// The first part of the path to `command` to be tried: half a clearance where the ferrule may be in
// the way, but not too small a part.
double first_part(const World& world, const State& state, const Pose& command) noexcept {
  const double travel = command_travel(world, state, command);
  const double clearance = world.annulus.clearance();
  const double first = world.numerics.solver.first_travel;
  if (travel <= first * clearance) return 1;
  // Clear of the ferrule before and after: nothing in the way.
  const double lever = state.inserted_length() + world.annulus.fibre_radius;
  const double nearest =
      std::min({state.tip[0], state.command[0], command[0]}) -
      lever * (state.tip.tail<2>().norm() + command.tail<2>().norm() + world.end.cleave.norm());
  if (nearest > world.profile.lead_in_length + clearance) return 1;
  return std::max(first * clearance / travel, 1.0 / kFirstParts);
}

// How far the rim slides in a sub-step over an edge [m].
double edge_step(const World& world) noexcept {
  return kEdgeStep * world.end.rounding();
}

// The largest part of a path along x of length `along_x` [m] for an end in frictional contact near
// the edge between bore and cone: up to where its rim goes round the edge, and there in short
// parts, as friction and adhesion turn.
double part_to_edge(const World& world, const State& state, double along_x) noexcept {
  const double tangent = world.profile.lead_in_tangent;
  if (!state.contact[kEnd].closed || state.side == EdgeSide::face || !(tangent > 0))
    return INFINITY;
  const PoseVector tip(state.tip);
  const double out = tip.e.norm() > 0 ? tip.e.dot(tip.t + world.end.cleave) / tip.e.norm() : 0.0;
  const double rho = world.end.rounding(), near = kNearEdge * rho;
  const double turning = rho * tangent * world.profile.lead_in_cosine();
  const double rim = tip.x + world.end.edge - world.annulus.fibre_radius * out;
  const double left = near + (along_x > 0 ? turning - rim : rim);
  if (left < 0) return INFINITY;
  return std::max(edge_step(world), left - turning - 2 * near) / std::abs(along_x);
}

// The linearization's curvature is that of a sub-step as long as the one before; for `part` of
// that.
void shorten_curvature(double part, WarmStart& warm_start) noexcept {
  if (!(part < 1)) return;
  PoseVector& curvature = warm_start.linearization.curvature;
  curvature = part * part * curvature;
}

// --- Why a sub-step is rejected ---

// Where a sub-step may be rejected, to be divided. Over an edge, where much turns and the search
// needs more evaluations, only where the end's contact opens.
enum class Divisible { no, where_end_opens, at_events };

// Has something happened between `before` and the iterate? What, or null.
const char* event_in(const World& world, const State& before, const FrozenCoefficients& frozen,
                     const Iterate& iterate, const Contacts& contacts, double travel) noexcept {
  if (contact_set_changed(before, contacts)) return "contact set changed";
  const EdgeSide side = frozen.contact.side;
  if (before.side != side || side_of(world, iterate.tip, side) != side) return "end left the face";
  if ((iterate.tip.position() - before.tip.head<3>()).norm() >
      world.numerics.solver.snap_ratio * travel)
    return "snap";
  return nullptr;
}

const char* rejection(Divisible divisible, const State& before, const Iterate& iterate,
                      const Contacts& contacts, const char* event) noexcept {
  if (divisible == Divisible::at_events) return iterate.converged ? event : "not converged soon";
  const bool opened = before.contact[kEnd].closed && !contacts.contact[kEnd].closed;
  return divisible == Divisible::where_end_opens && opened ? "end's contact opened" : nullptr;
}

// --- What is accepted ---

// Contacts after a sub-step that has moved the end: new ones stick where they are, sliding ones
// drag their sticking point along. Where a contact moves on over the fibre it is another material
// point's, and the elastic slip stays. A spot that grows is not sheared where it is new: the force
// stays and the slip becomes less; one that shrinks gives up its part of the force (Mindlin and
// Deresiewicz, 1953). So no energy is gained.
void update_contacts(const World& world, const FrozenCoefficients& frozen, const Iterate& iterate,
                     const Contacts& contacts, State& state) noexcept {
  if (!contacts.contact[kEnd].closed && !contacts.contact[kSide].closed) {
    state.contact = contacts.contact;
    return;
  }
  const ContactSide side = contact_side(world, state.tip, state.side);
  for (int place = 0; place < kContactPlaces; ++place) {
    ContactState& contact = state.contact[place];
    const bool was_closed = contact.closed;
    contact = contacts.contact[place];
    if (!contact.closed) continue;
    contact.stuck = material_point(world, side, place, iterate.tip);
    const FrozenFriction& friction = frozen.friction[place];
    if (!was_closed || !friction.acts) continue;
    const Vector3d slip = elastic_slip(world, frozen, place, iterate.tip);
    const double length = slip.norm(), allowed = friction.limit / friction.stiffness;
    const double stiffness =
        sticking_stiffness(world, frozen, iterate.tip, iterate.potential, place);
    double part = length > allowed ? allowed / length : 1;
    if (stiffness > friction.stiffness) part *= friction.stiffness / stiffness;
    contact.stuck -= part * slip;
  }
}

// Velocities after a sub-step that ends at `tip`, by the rule that it used.
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

// Takes the iterate as the state after a sub-step over `dt` to `command`.
void accept(const World& world, const Pose& command, double dt, const FrozenCoefficients& frozen,
            const Iterate& iterate, const Contacts& contacts, StepResult& now) noexcept {
  State& state = now.state;
  const Pose tip = iterate.tip.full();
  update_velocity(frozen, tip, dt, state);
  // A velocity that jumps is not extrapolated.
  if (frozen.inertial && contact_set_changed(state, contacts)) state.dt_before = 0;
  state.tip = tip;
  state.command = command;
  state.side = frozen.contact.side;
  update_contacts(world, frozen, iterate, contacts, state);
  state.bridge = contacts.bridge;
  state.air = tip[0] < 0 ? frozen.flow.air_at(-tip[0]) : 0;
  const Energy& bore = iterate.potential.bore;
  now.warm_start.linearization = {tip, bore.gradient, bore.hessian, iterate.curvature};
}

// --- Solving ---

// Where the next sub-step of a path ends, as a part of it, and whether it may be divided.
struct SubStep {
  double to;
  bool last;
  Divisible divisible;
};
SubStep next_sub_step(const World& world, const State& state, double along_x, double travel,
                      double shortest, double first, int evaluations_left,
                      const EventSearch& events) noexcept {
  const SolverParameters& parameters = world.numerics.solver;
  const double done = events.done(), edge = part_to_edge(world, state, along_x);
  SubStep next{events.bracketed() ? events.next() : done + std::min(first, edge), false,
               Divisible::no};
  const bool affordable =
      evaluations_left > parameters.reserved_evaluations + parameters.divisible_evaluations;
  next.last = !affordable || next.to > 1 - 1e-9;
  if (next.last) next.to = 1;
  const double length = (next.to - done) * travel;
  const bool over_edge = !events.bracketed() && edge < first && length <= 1.01 * edge_step(world);
  if (affordable && (events.bracketed() ? events.divisible(next.to) : length > shortest))
    next.divisible = over_edge ? Divisible::where_end_opens : Divisible::at_events;
  return next;
}

// Follows the path to `command` over `dt` in sub-steps, long ones while nothing happens and short
// ones where it does, with at most SolverParameters::max_evaluations together.
void follow_path(const World& world, const Pose& command, double dt, StepResult& now,
                 StepTrace* trace) noexcept {
  const SolverParameters& parameters = world.numerics.solver;
  State& state = now.state;
  const int budget = now.evaluations + parameters.max_evaluations;
  const Pose from = state.command;
  const double travel = command_travel(world, state, command);
  const double shortest =
      std::max(world.numerics.event_travel, travel * parameters.shortest_substep);
  const double first = first_part(world, state, command);
  EventSearch events(shortest / travel);
  for (double longest = NAN; events.done() < 1;) {
    const double done = events.done();
    const int left = budget - now.evaluations;
    const SubStep next =
        next_sub_step(world, state, command[0] - from[0], travel, shortest, first, left, events);
    const double to = next.to;
    shorten_curvature((to - done) / longest, now.warm_start);
    longest = std::fmin(longest, to - done);
    const Pose goal = next.last ? command : Pose(from + to * (command - from));
    const double over = (to - done) * dt;
    const int most = next.last ? left : left - parameters.reserved_evaluations;
    if (trace) trace->part = to;

    // Predict, correct, minimise, couple friction.
    FrozenCoefficients frozen = freeze(world, state, goal, over);
    double where = NAN;  // about which part of the sub-step something happens at
    const bool stops = next.divisible == Divisible::at_events;
    const Iterate iterate =
        solve_sub_step(world, now, goal, over, most, stops ? &where : nullptr, frozen, trace);
    now.evaluations += iterate.evaluations;
    now.iterations += iterate.iterations;

    // Locate events: reject, or accept.
    const Contacts contacts = ferrule::contacts(world, frozen, iterate.tip, iterate.potential);
    const char* event =
        event_in(world, state, frozen, iterate, contacts, command_travel(world, state, goal));
    if (const char* why = rejection(next.divisible, state, iterate, contacts, event)) {
      note(iterate, SolverStage::rejected, why);
      events.reject(world, now, to, where);
      ++now.rejected;
      continue;
    }
    now.status = iterate.converged ? StepStatus::ok
                 : iterate.spent   ? StepStatus::iteration_limit
                                   : StepStatus::not_converged;
    note(iterate, SolverStage::accepted,
         event               ? event
         : iterate.converged ? "converged"
                             : "not converged");
    accept(world, goal, over, frozen, iterate, contacts, now);
    ++now.substeps;
    if (next.last) {
      now.warm_start.forces = {};
      forces(world, frozen, iterate.tip, iterate.potential, now.warm_start.forces);
      now.holder = now.warm_start.forces.holder;
      set_extrapolation(world, frozen, iterate, over, now);
    }
    events.accept(world, now, to, event != nullptr);
  }
}

// A command that is no command: the state is unchanged.
void refuse(const World& world, StepResult& now) noexcept {
  now = StepResult(now.state);
  now.status = StepStatus::bad_command;
  now.holder = forces(world, now).holder;
}

bool is_valid(const Pose& command, double dt) noexcept {
  const bool finite = (0 * command).sum() == 0;
  return finite && dt >= 0 && dt < INFINITY;
}

}  // namespace

void step_on(const World& world, const Pose& command, double dt, StepResult& now,
             StepTrace* trace) noexcept {
  if (!is_valid(command, dt)) return refuse(world, now);
  if (extrapolate(world, command, dt, now, trace)) return;
  if (fly_free(world, command, dt, now)) {
    if (trace) trace->add({SolverStage::free_flight, "nothing is near the fibre", 1, 0, NAN, NAN});
    return;
  }
  // Near the ferrule, or with inertia: solved, in parts no longer than the world allows.
  const State before = now.state;
  const std::optional<Extrapolation> last = now.warm_start.extrapolation;
  now.status = StepStatus::ok;
  now.evaluations = now.iterations = now.substeps = now.rejected = 0;
  now.state.time = before.time + dt;
  now.state = end_extrapolation(world, now);
  now.warm_start.extrapolation.reset();
  const int parts = parts_of(world, dt);
  for (int k = 1; k <= parts; ++k) {
    const double part = static_cast<double>(k) / parts;
    const Pose to = k == parts ? command : Pose(before.command + part * (command - before.command));
    follow_path(world, to, dt / parts, now, trace);
  }
  if (last) set_trust_radius(world, before, *last, now);
}

StepResult step(const World& world, const State& state, const Pose& command, double dt,
                StepTrace* trace) noexcept {
  StepResult result(state);
  step_on(world, command, dt, result, trace);
  return result;
}

Breakdown forces(const World& world, const StepResult& now) noexcept {
  if (now.evaluations > 0) return now.warm_start.forces;
  const State here = end_extrapolation(world, now);
  PoseVector tip(here.tip);
  Breakdown breakdown;
  if (!now.extrapolated()) {
    const FrozenCoefficients frozen = freeze(world, here, here.command, 0);
    forces(world, frozen, tip, Potential(world, frozen, tip), breakdown);
    return breakdown;
  }
  // Walls are so stiff that within the extrapolation's error forces are out of balance: a Newton
  // step, without another evaluation, to where they are in it.
  const Extrapolation& extrapolation = *now.warm_start.extrapolation;
  FrozenCoefficients frozen = freeze(world, here, here.command, extrapolation.dt);
  frozen.from -= extrapolation.last;
  frozen.load += PoseMatrix(world.holder.stiffness).times(extrapolation.last);
  Potential potential(world, frozen, tip);
  const Energy& bore = potential.bore;
  const PoseVector move =
      NewtonStep(world, frozen, without_friction(world, frozen, tip, bore.gradient, bore.hessian),
                 tip)
          .move;
  potential.follow(move, tip);
  tip += move;
  forces(world, frozen, tip, potential, breakdown);
  breakdown.holder = now.holder;
  return breakdown;
}

}  // namespace ferrule
