#include "sim/tangent.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "sim/particle_depth.hpp"

namespace ferrule {
namespace {

constexpr double kAimedAt = 0.25;         // of the error that is allowed, at the end of a stretch
constexpr double kLonger = 3;             // a stretch than the one before, at most
constexpr double kLongestStretch = 0.15;  // a stretch, as way_of() has it
constexpr double kAlongTheBore = 0.05;    // of a way across, in what it changes
constexpr double kLeastGap = 1e-9;        // [m]
constexpr double kAdheres = 20e-9;        // from so far away, at most [m]
constexpr double kDepthKept = 0.5;        // of a closed contact's depth
constexpr double kSlipKept = 0.5;         // of how far it slips in a step
constexpr double kStraightSlip = 0.9;     // cosine of the angle by which that may turn
constexpr double kFromEdge = 0.2e-6;      // [m]

bool follows_tangents(const World& world) noexcept {
  return world.numerics.tangent_tip > 0 && world.dynamics == Dynamics::quasi_static &&
         !depends_on_speed(world.laws);
}

// Between which edges of the ferrule all of the rim of the end at `tip` is.
void set_range(const World& world, const PoseVector& tip, Tangent& tangent) noexcept {
  const double rim = world.annulus.fibre_radius * (tip.t.norm() + world.end.cleave.norm()) +
                     world.end.rounding() + kFromEdge;
  const bool inside = tip.x < 0;
  tangent.least_x = inside ? rim - world.profile.length : rim;
  tangent.most_x = inside ? -rim - kPatch : world.profile.lead_in_length - rim;
}

constexpr double kFromParticle = 50e-9;  // [m]

// Is no particle near?
bool is_clear(const World& world, const PoseVector& tip) noexcept {
  return !world.laws.particle || particle_depth(world, tip).value < -kFromParticle;
}

// The Hessian of all forces, with the limits of friction.
Matrix5 stiffness(const World& world, const FrozenCoefficients& frozen,
                  const Minimum& found) noexcept {
  const Potential& there = found.there;
  Energy all = without_friction(frozen, found.tip, there.bore.gradient, there.bore.hessian);
  std::array<Vector3d, kContactPlaces> stretched;
  for (std::size_t at = 0; at < kContactPlaces; ++at) {
    if (!frozen.friction[at].acts) continue;
    const int place = static_cast<int>(at);
    stretched[at] = stretch(world, frozen, place, found.tip);
    add_friction_about(all, world, frozen, place, stretched[at], stretched[at]);
  }
  Matrix5 sum = all.hessian.full();
  for (std::size_t at = 0; at < kContactPlaces; ++at) {
    const FrozenFriction& friction = frozen.friction[at];
    if (!friction.acts || !friction.slips(stretched[at])) continue;
    const PoseVector pull = pull_of_friction(world, frozen, static_cast<int>(at), stretched[at]);
    sum +=
        friction.per_depth * pull.full() * there.depth[at].by_pose(found.tip.t).full().transpose();
  }
  return sum;
}

Tangent::Place place_of(const World& world, const FrozenCoefficients& frozen, const Minimum& found,
                        const ContactSide& side, int at, const ContactState& contact) noexcept {
  Tangent::Place place;
  const ContactDepth& depth = found.there.depth[static_cast<std::size_t>(at)];
  if (depth.value == -INFINITY) return place;
  place.near = !contact.closed;
  place.depth = depth.value;
  place.depth_slope = depth.by_pose(found.tip.t).full();
  const FrozenFriction& friction = frozen.friction[static_cast<std::size_t>(at)];
  place.rubs = contact.closed && friction.acts;
  if (!place.rubs) return place;
  for (int i = 0; i < 5; ++i)
    place.stretching.col(i) = stretch_by(world, frozen, at, PoseVector(Pose(Pose::Unit(i))));
  const Vector3d stretched = stretch(world, frozen, at, found.tip);
  place.slips = friction.slips(stretched);
  place.longest = friction.limit / friction.stiffness;
  place.stretch = material_point(world, side, at, found.tip) - contact.stuck;
  place.slid = stretched.norm() - place.longest;
  return place;
}

// How far the fibre goes, by what changes as it does: in clearances across, and in parts of the
// gaps.
double way_of(const World& world, const State& state, const Pose& by, const Pose& move) noexcept {
  const double lever = state.inserted_length() + world.annulus.fibre_radius;
  double way =
      (kAlongTheBore * std::abs(by[0]) + by.segment<2>(1).norm() + lever * by.tail<2>().norm()) /
      world.annulus.clearance();
  for (const Tangent::Place& place : state.tangent->place)
    if (place.near || place.rubs)
      way += std::abs(place.depth_slope.dot(move)) / std::max(std::abs(place.depth), kLeastGap);
  return way;
}

// Does nothing happen at a place that comes `deeper` and slides by `slid`?
bool goes_on(const World& world, const Tangent::Place& place, const ContactState& contact,
             double deeper, const Vector3d& slid) noexcept {
  if (place.near) {
    const double depth = place.depth + deeper;
    if (depth < -kAdheres) return true;
    const AdhesionForce pull = adhesion_force(world.laws, depth, contact.branch);
    return depth <= 0 && pull.radius == 0 && pull.branch == contact.branch;
  }
  if (!contact.closed) return true;
  if (std::abs(contact.depth + deeper - place.depth) > kDepthKept * std::abs(place.depth))
    return false;
  if (!place.rubs) return true;
  if (!place.slips) return (place.stretch + slid).norm() <= place.longest;
  const double length = slid.norm();
  return length >= kSlipKept * place.slid && kSlipKept * length <= place.slid &&
         slid.dot(place.stretch) >= kStraightSlip * length * place.stretch.norm();
}

}  // namespace

std::optional<TangentStep> along_tangent(const World& world, const State& state,
                                         const Pose& command) noexcept {
  const Tangent& tangent = *state.tangent;
  TangentStep next;
  const Pose by = command - state.command;
  next.move = tangent.tip_by_command * by;
  next.way = tangent.way + way_of(world, state, by, next.move);
  if (!(next.way <= tangent.reach)) return std::nullopt;
  const Pose tip = state.tip + next.move;
  if (!(tip[0] >= tangent.least_x && tip[0] <= tangent.most_x)) return std::nullopt;
  if (!is_clear(world, tip)) return std::nullopt;
  if (present(world.laws.capillary) &&
      bridge_at(world, state.bridge, world.oval.stretched(tip)) != state.bridge)
    return std::nullopt;
  for (std::size_t at = 0; at < kContactPlaces; ++at) {
    const Tangent::Place& place = tangent.place[at];
    next.deeper[at] = place.depth_slope.dot(next.move);
    if (place.rubs) next.slid[at] = place.stretching * next.move;
    if (!goes_on(world, place, state.contact[at], next.deeper[at], next.slid[at]))
      return std::nullopt;
  }
  return next;
}

void follow_tangent(const World& world, const Pose& command, double dt, const TangentStep& next,
                    StepResult& now) noexcept {
  State& state = now.state;
  if (now.substeps == 0) now.forces = state.tangent->forces;  // else they are those of a step to it
  state.tip += next.move;
  state.command = command;
  state.time += dt;
  state.tangent->way = next.way;
  for (std::size_t at = 0; at < kContactPlaces; ++at) {
    Tangent::Place& place = state.tangent->place[at];
    (place.near ? place.depth : state.contact[at].depth) += next.deeper[at];
    if (place.rubs) (place.slips ? state.contact[at].stuck : place.stretch) += next.slid[at];
  }
  now.forces.holder = world.holder.stiffness * (state.tip - command);
  now.status = StepStatus::ok;
  now.evaluations = now.iterations = now.halvings = 0;
  now.substeps = 1;
}

void leave_tangent(const World& world, State& state) noexcept {
  if (!state.tangent) return;
  const ContactSide side = contact_side(world, state);
  const PoseVector tip(state.tip);
  for (int at = 0; at < kContactPlaces; ++at) {
    const Tangent::Place& place = state.tangent->place[at];
    if (place.rubs) state.contact[at].stuck = material_point(world, side, at, tip) - place.stretch;
  }
  state.tangent.reset();
  if (!state.linearization || state.linearization->at == state.tip) return;
  Linearization& bore = *state.linearization;
  bore.gradient += bore.hessian.times(PoseVector(Pose(state.tip - bore.at)));
  bore.at = state.tip;
}

void set_tangent(const World& world, const FrozenCoefficients& frozen, const Minimum& found,
                 const Breakdown& forces, State& state) noexcept {
  state.tangent.reset();
  if (!follows_tangents(world) || !found.converged || state.side == EdgeSide::face) return;
  Tangent tangent;
  set_range(world, found.tip, tangent);
  if (!(found.tip.x >= tangent.least_x && found.tip.x <= tangent.most_x)) return;
  if (!is_clear(world, found.tip)) return;
  tangent.tip_by_command =
      stiffness(world, frozen, found).partialPivLu().solve(world.holder.stiffness);
  const ContactSide side = contact_side(world, state);
  for (int at = 0; at < kContactPlaces; ++at)
    tangent.place[at] = place_of(world, frozen, found, side, at, state.contact[at]);
  tangent.forces = forces;
  state.tangent = tangent;
}

void set_reach(const World& world, const State& before, StepResult& result) noexcept {
  State& now = result.state;
  if (!now.tangent || !before.tangent || result.status != StepStatus::ok || result.halvings > 0)
    return;
  for (std::size_t at = 0; at < kContactPlaces; ++at)
    if (now.contact[at].closed != before.contact[at].closed ||
        now.contact[at].branch != before.contact[at].branch)
      return;
  if (now.bridge != before.bridge) return;
  const Pose by = now.command - before.command, move = before.tangent->tip_by_command * by;
  const double way = before.tangent->way + way_of(world, before, by, move);
  const Pose miss = now.tip - before.tip - move;
  const Numerics& n = world.numerics;
  const double lever = now.inserted_length() + world.annulus.fibre_radius;
  const double tip = miss.head<3>().norm() + lever * miss.tail<2>().norm();
  const double force = (world.holder.stiffness * miss).head<3>().norm();
  const double error = std::max(tip / n.tangent_tip, force / n.tangent_force);
  const double factor = error > 0 ? std::sqrt(kAimedAt / error) : kLonger;
  now.tangent->reach = std::min(way * std::min(factor, kLonger), kLongestStretch);
}

}  // namespace ferrule
