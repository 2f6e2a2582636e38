#include "sim/solver/extrapolation.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "sim/solver/friction_coupling.hpp"
#include "sim/terms/contact.hpp"
#include "sim/terms/particle_depth.hpp"
#include "sim/terms/printed_well.hpp"

namespace ferrule {
namespace {

constexpr double kAlongTheBore = 0.05;  // of a move across, in what it changes
constexpr double kLeastGap = 1e-9;      // [m]
constexpr double kKept = 0.5;           // of a closed contact's depth, and of its elastic slip
constexpr double kLateralSlip = 0.2;    // of that, at most
constexpr double kToFold = 0.25;        // of what is left of the path to one
constexpr double kFromPrinted = 2e-9;   // a printed surface: too steep to extrapolate [m]

bool extrapolates(const World& world) noexcept {
  const Numerics& n = world.numerics;
  return std::min(n.extrapolation_tip, n.extrapolation_force) > 0 &&
         world.dynamics == Dynamics::quasi_static && !world.laws.flow;
}

// Between which edges of the ferrule all of the rim of the end at `tip` is.
void set_range(const World& world, const PoseVector& tip, Extrapolation& extrapolation) noexcept {
  const double rim = world.annulus.fibre_radius * (tip.t.norm() + world.end.cleave.norm()) +
                     world.end.rounding() + kSharpRounding;
  const bool inside = tip.x < 0;
  extrapolation.least_x = inside ? rim - world.profile.length : rim;
  extrapolation.most_x = inside ? -rim - kPatch : world.profile.lead_in_length - rim;
}

// Does it touch no particle?
bool is_clear(const World& world, const PoseVector& tip) noexcept {
  return !world.laws.particle || particle_depth(world, tip).value < 0;
}

// What the move over the step before changes the force of the drag by.
Matrix5 drag_of_last(const FrozenCoefficients& frozen) noexcept {
  PoseMatrix drag;
  drag.xx = frozen.axial_drag * std::max(0.0, -frozen.from.x);
  for (const double arm : frozen.drag_arm) {
    drag.ee += frozen.drag_per_move;
    drag.et += arm * frozen.drag_per_move;
    drag.tt += arm * arm * frozen.drag_per_move;
  }
  return drag.full();
}

Extrapolation::Place place_of(const World& world, const FrozenCoefficients& frozen,
                              const Iterate& iterate, const CoupledModel& model,
                              const ContactSide& side, int at,
                              const ContactState& contact) noexcept {
  Extrapolation::Place place;
  const ContactDepth& depth = iterate.potential.depth[static_cast<std::size_t>(at)];
  if (depth.value == -INFINITY) return place;
  place.open = !contact.closed;
  place.depth = depth.value;
  place.depth_slope = depth.by_pose(iterate.tip.t).full();
  const FrozenFriction& friction = frozen.friction[static_cast<std::size_t>(at)];
  place.friction_acts = contact.closed && friction.acts;
  if (!place.friction_acts) return place;
  for (int i = 0; i < 5; ++i)
    place.slip_by_tip.col(i) = elastic_slip_by(world, frozen, at, PoseVector(Pose(Pose::Unit(i))));
  const Vector3d slip = elastic_slip(world, frozen, at, iterate.tip);
  place.slides = friction.slides(slip);
  place.limit_slip = friction.limit / friction.stiffness;
  place.slip = material_point(world, side, at, iterate.tip) - contact.stuck;
  const double length = slip.norm();
  place.beyond = length - place.limit_slip;
  if (!place.slides) return place;
  // The limit grows with the spot's radius to the power n, the sticking stiffness as the radius.
  const Friction& law = *friction_law(world.laws);
  const double radius = friction.stiffness / (friction.patch * sticking_stiffness(law, 1));
  place.limit_by_depth =
      (1 - 1 / friction_exponent(law, radius)) * friction.per_depth / friction.stiffness;
  place.lateral_direction = depth.normal(iterate.tip.t).cross(slip).normalized();
  const Pose turn = place.slip_by_tip.transpose() * place.lateral_direction;
  place.tip_by_lateral =
      -place.beyond * friction.limit / (length * length) * model.solve(PoseVector(turn)).full();
  return place;
}

// How far the hand or the fibre goes, by what changes as they do: in clearances across, and in
// parts of the gaps.
double arc_length_of(const World& world, const State& state, const Extrapolation& extrapolation,
                     const Pose& by, const Pose& move) noexcept {
  const double lever = state.inserted_length() + world.annulus.fibre_radius;
  const auto more = [](const auto& a, const auto& b) {
    return std::sqrt(std::max(a.squaredNorm(), b.squaredNorm()));
  };
  double length =
      (kAlongTheBore * std::max(std::abs(by[0]), std::abs(move[0])) +
       more(by.segment<2>(1), move.segment<2>(1)) + lever * more(by.tail<2>(), move.tail<2>())) /
      world.annulus.clearance();
  for (const Extrapolation::Place& place : extrapolation.place)
    if (place.open || place.friction_acts)
      length += std::abs(place.depth_slope.dot(move)) / std::max(std::abs(place.depth), kLeastGap);
  return length;
}

// What the end moves by as the hand moves `by`.
Pose follow_hand(const World& world, const Extrapolation& extrapolation, const Pose& by) noexcept {
  Pose move = extrapolation.tip_by_command * by;
  if (world.laws.drag) move += extrapolation.tip_by_last * extrapolation.last;
  for (const Extrapolation::Place& place : extrapolation.place)
    if (place.lateral != 0) move += place.lateral * place.tip_by_lateral;
  return move;
}

// The lateral slip of a place that slides, after it has slid so.
double lateral_after(const Extrapolation::Place& place, const Vector3d& slid) noexcept {
  return place.lateral_direction.dot(slid) +
         place.limit_slip / (place.limit_slip + place.beyond) * place.lateral;
}

// Does nothing happen at a place that becomes `deeper` and slips by `slid`? Null, or what does.
const char* event_at(const World& world, const Extrapolation::Place& place,
                     const ContactState& contact, double deeper, const Vector3d& slid) noexcept {
  if (place.open) {
    const double depth = place.depth + deeper;
    const AdhesionForce pull = adhesion_force(world.laws, depth, contact.branch);
    const bool apart = depth <= 0 && pull.radius == 0 && pull.branch == contact.branch;
    return apart ? nullptr : "solved: a contact closes";
  }
  if (!contact.closed) return nullptr;
  if (std::abs(contact.depth + deeper - place.depth) > kKept * std::abs(place.depth))
    return "solved: a contact's depth has changed by half";
  if (!place.friction_acts) return nullptr;
  if (!place.slides)
    return (place.slip + slid).norm() <= place.limit_slip ? nullptr : "solved: a contact slides";
  const double on = slid.dot(place.slip) / place.limit_slip;
  const double length = place.limit_slip + place.beyond;
  const bool slides_on = on > 0 && place.limit_slip + on >= kKept * length &&
                         kKept * (place.limit_slip + on) <= length &&
                         std::abs(lateral_after(place, slid)) <= kLateralSlip * length;
  return slides_on ? nullptr : "solved: sliding slows, speeds up or turns";
}

// A step along the extrapolation.
struct ExtrapolatedStep {
  Pose move;
  double arc_length;                            // Extrapolation::arc_length after it
  std::array<double, kContactPlaces> deeper{};  // [m]
  std::array<Vector3d, kContactPlaces> slid = {Vector3d::Zero(), Vector3d::Zero()};  // [m]
};

// That from `now`, which has an extrapolation, to `command`. Null, or why the step is to be solved.
const char* try_extrapolated(const World& world, const StepResult& now, const Pose& command,
                             double dt, ExtrapolatedStep& next) noexcept {
  if (!extrapolates(world)) return "solved: nothing is extrapolated";
  const State& state = now.state;
  const Extrapolation& extrapolation = *now.warm_start.extrapolation;
  if (extrapolation.trust_radius == 0) return "solved: no trust radius yet";
  const Pose by = command - state.command;
  if (world.laws.drag && dt != extrapolation.dt) return "solved: another step in time";
  next.move = follow_hand(world, extrapolation, by);
  next.arc_length =
      extrapolation.arc_length + arc_length_of(world, state, extrapolation, by, next.move);
  if (!(next.arc_length <= extrapolation.trust_radius)) return "solved: beyond the trust radius";
  const Pose tip = state.tip + next.move;
  if (!(tip[0] >= extrapolation.least_x && tip[0] <= extrapolation.most_x))
    return "solved: near an edge";
  if (!is_clear(world, tip)) return "solved: at a particle";
  if (present(world.laws.capillary) &&
      bridge_at(world, state.bridge, world.oval.stretched(tip)) != state.bridge)
    return "solved: the bridge changes";
  for (std::size_t at = 0; at < kContactPlaces; ++at) {
    const Extrapolation::Place& place = extrapolation.place[at];
    next.deeper[at] = place.depth_slope.dot(next.move);
    if (place.friction_acts) next.slid[at] = place.slip_by_tip * next.move;
    if (const char* event =
            event_at(world, place, state.contact[at], next.deeper[at], next.slid[at]))
      return event;
  }
  return nullptr;
}

void take(const World& world, const Pose& command, double dt, const ExtrapolatedStep& next,
          StepResult& now) noexcept {
  State& state = now.state;
  Extrapolation& extrapolation = *now.warm_start.extrapolation;
  state.tip += next.move;
  Linearization& bore = now.warm_start.linearization;
  bore.gradient += bore.hessian.times(PoseVector(next.move));
  bore.at = state.tip;
  state.command = command;
  state.time += dt;
  extrapolation.arc_length = next.arc_length;
  if (world.laws.drag) extrapolation.last = next.move;
  for (std::size_t at = 0; at < kContactPlaces; ++at) {
    Extrapolation::Place& place = extrapolation.place[at];
    (place.open ? place.depth : state.contact[at].depth) += next.deeper[at];
    if (place.slides) place.lateral = lateral_after(place, next.slid[at]);
    if (place.friction_acts) (place.slides ? state.contact[at].stuck : place.slip) += next.slid[at];
  }
  now.holder = world.holder.stiffness * (state.tip - command);
  now.status = StepStatus::ok;
  now.evaluations = now.iterations = now.rejected = 0;
  now.substeps = 1;
}

}  // namespace

bool extrapolate(const World& world, const Pose& command, double dt, StepResult& now,
                 StepTrace* trace) noexcept {
  if (!now.warm_start.extrapolation) return false;
  ExtrapolatedStep next;
  const char* why = try_extrapolated(world, now, command, dt, next);
  if (trace)
    trace->add({SolverStage::extrapolation, why ? why : "extrapolated", 1, 0, NAN,
                why ? NAN : next.move.head<3>().norm() / world.annulus.clearance()});
  if (!why) take(world, command, dt, next, now);
  return !why;
}

State end_extrapolation(const World& world, const StepResult& now) noexcept {
  State state = now.state;
  if (!now.warm_start.extrapolation) return state;
  const Extrapolation& extrapolation = *now.warm_start.extrapolation;
  if (extrapolation.arc_length == 0) return state;
  const ContactSide side = contact_side(world, state.tip, state.side);
  const PoseVector tip(state.tip);
  const auto depth = contact_depths(world, side, tip);
  for (int at = 0; at < kContactPlaces; ++at) {
    const Extrapolation::Place& place = extrapolation.place[at];
    ContactState& contact = state.contact[at];
    if (contact.closed) contact.depth = depth[at].value;
    if (!place.friction_acts) continue;
    Vector3d slip = place.slip;
    if (place.slides) {
      const double length = place.limit_slip + place.beyond;
      const double longer = place.limit_by_depth * (contact.depth - place.depth);
      slip = (1 + longer / place.limit_slip) * slip.norm() *
             (length * slip.normalized() + place.lateral * place.lateral_direction).normalized();
    }
    contact.stuck = material_point(world, side, at, tip) - slip;
  }
  return state;
}

void set_extrapolation(const World& world, const FrozenCoefficients& frozen, const Iterate& iterate,
                       double dt, StepResult& now) noexcept {
  const State& state = now.state;
  now.warm_start.extrapolation.reset();
  if (!extrapolates(world) || !iterate.converged || state.side == EdgeSide::face) return;
  if (std::abs(printed_gap(world, frozen, iterate.tip)) < kFromPrinted) return;
  Extrapolation extrapolation;
  set_range(world, iterate.tip, extrapolation);
  if (!(iterate.tip.x >= extrapolation.least_x && iterate.tip.x <= extrapolation.most_x)) return;
  if (!is_clear(world, iterate.tip)) return;
  const NewtonStep newton = stationary_step(world, frozen, iterate);
  const FrictionCoupling coupling(world, frozen, iterate.tip, iterate.potential);
  const CoupledModel model(newton, coupling);
  if (!model.stable()) return;
  extrapolation.determinant = model.determinant();
  extrapolation.tip_by_command = follow_forces(model, world.holder.stiffness);
  if (world.laws.drag) {
    extrapolation.tip_by_last = follow_forces(model, drag_of_last(frozen));
    extrapolation.last = (iterate.tip - frozen.from).full();
    extrapolation.dt = dt;
  }
  const ContactSide side = contact_side(world, state.tip, state.side);
  for (int at = 0; at < kContactPlaces; ++at)
    extrapolation.place[at] = place_of(world, frozen, iterate, model, side, at, state.contact[at]);
  now.warm_start.extrapolation = extrapolation;
}

void set_trust_radius(const World& world, const State& before, const Extrapolation& last,
                      StepResult& now) noexcept {
  if (!now.warm_start.extrapolation || now.status != StepStatus::ok || now.rejected > 0) return;
  const State& state = now.state;
  Extrapolation& extrapolation = *now.warm_start.extrapolation;
  if (contact_set_changed(before, {state.contact, state.bridge})) return;
  const Pose by = state.command - before.command, move = follow_hand(world, last, by);
  const double length = last.arc_length + arc_length_of(world, before, last, by, move);
  const Pose error = state.tip - before.tip - move;
  const Numerics& n = world.numerics;
  const double lever = state.inserted_length() + world.annulus.fibre_radius;
  const double tip = error.head<3>().norm() + lever * error.tail<2>().norm();
  const double force = (world.holder.stiffness * error).head<3>().norm();
  const double relative = std::max(tip / n.extrapolation_tip, force / n.extrapolation_force);
  const double factor = relative > 0 ? std::sqrt(n.solver.extrapolation_error / relative)
                                     : n.solver.extrapolation_growth;
  double& radius = extrapolation.trust_radius;
  radius = std::min(length * std::min(factor, n.solver.extrapolation_growth),
                    n.solver.extrapolation_longest);
  // Up to a fold, where the pose is lost, the determinant falls as the root of what is left of the
  // path.
  const double det_before = last.determinant, det_now = extrapolation.determinant;
  if (det_now < det_before)
    radius = std::min(radius, kToFold * length * det_now * det_now /
                                  (det_before * det_before - det_now * det_now));
}

}  // namespace ferrule
