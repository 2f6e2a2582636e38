#include "sim/tangent.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "sim/particle_depth.hpp"

namespace ferrule {
namespace {

constexpr double kAimedAt = 0.25;  // of the error that is allowed, at the end of a stretch
// A stretch than the one before, at most. No whole number, or rounding would decide in which of
// equal steps it ends.
constexpr double kLonger = 3.1416;
constexpr double kLongestStretch = 0.15;  // a stretch, as way_of() has it
constexpr double kAlongTheBore = 0.05;    // of a way across, in what it changes
constexpr double kLeastGap = 1e-9;        // [m]
constexpr double kAdheres = 20e-9;        // from so far away, at most [m]
constexpr double kDepthKept = 0.5;        // of a closed contact's depth
constexpr double kSlipKept = 0.5;         // of what a spring is stretched before it slips
constexpr double kStraightSlip = 0.2;     // of that, what it may be stretched across
constexpr double kToFold = 0.25;          // of the way to one
constexpr double kFromEdge = 0.2e-6;      // [m]
constexpr double kNearPrinted = 2e-9;     // a printed surface: steeper than a tangent tells [m]

bool follows_tangents(const World& world) noexcept {
  const Numerics& n = world.numerics;
  return std::min(n.tangent_tip, n.tangent_force) > 0 && world.dynamics == Dynamics::quasi_static &&
         !world.laws.flow;
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

// What a force moves the end by, friction and how its limits give way included.
class Compliance {
 public:
  Compliance(const World& world, const FrozenCoefficients& frozen, const Minimum& found) noexcept {
    const Energy& bore = found.there.bore;
    Energy all = without_friction(frozen, found.tip, bore.gradient, bore.hessian);
    std::array<Vector3d, kContactPlaces> stretched;
    for (std::size_t at = 0; at < kContactPlaces; ++at) {
      if (!frozen.friction[at].acts) continue;
      const int place = static_cast<int>(at);
      stretched[at] = stretch(world, frozen, place, found.tip);
      add_friction_about(all, world, frozen, place, stretched[at], stretched[at]);
    }
    Eliminated given;  // at given limits
    holds_ = given.of(all.hessian) == 0;
    determinant_ = given.determinant();
    for (int k = 0; k < 5; ++k)
      inverse_.col(k) = -given.solve(PoseVector(Pose(Pose::Unit(k)))).full();
    for (std::size_t at = 0; at < kContactPlaces; ++at) {
      const FrozenFriction& friction = frozen.friction[at];
      if (!friction.acts || !friction.slips(stretched[at])) continue;
      const PoseVector pull = pull_of_friction(world, frozen, static_cast<int>(at), stretched[at]);
      add((friction.per_depth * pull).full(), found.there.depth[at].by_pose(found.tip.t).full());
    }
  }

  // Are such forces in balance, and stable?
  bool holds() const noexcept { return holds_; }
  double determinant() const noexcept { return determinant_; }
  Pose of(const Pose& force) const noexcept { return inverse_.lazyProduct(force); }
  // By columns.
  Matrix5 of(const Matrix5& forces) const noexcept { return inverse_.lazyProduct(forces); }

 private:
  // A gradient that changes by `by` with what has this slope (Sherman and Morrison, 1950).
  void add(const Pose& by, const Pose& slope) noexcept {
    const Pose answer = of(by);
    const double factor = 1 + slope.dot(answer);
    holds_ = holds_ && factor > 0;
    determinant_ *= factor;
    const Pose share = inverse_.transpose().lazyProduct(slope);
    inverse_ -= answer.lazyProduct((1 / factor * share).transpose());
  }

  Matrix5 inverse_;
  bool holds_ = false;
  double determinant_ = 0;
};

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

Tangent::Place place_of(const World& world, const FrozenCoefficients& frozen, const Minimum& found,
                        const Compliance& compliance, const ContactSide& side, int at,
                        const ContactState& contact) noexcept {
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
  const double length = stretched.norm();
  place.slid = length - place.longest;
  if (!place.slips) return place;
  // The limit grows with the spot's radius to the power n, the spring's stiffness as the radius.
  const Friction& law = *friction_law(world.laws);
  const double radius = friction.stiffness / (friction.patch * stuck_stiffness(law, 1));
  place.longer = (1 - 1 / friction_exponent(law, radius)) * friction.per_depth / friction.stiffness;
  place.across = depth.normal(found.tip.t).cross(stretched).normalized();
  const Pose turn = place.stretching.transpose() * place.across;
  place.tip_by_turned = compliance.of(Pose(place.slid * friction.limit / (length * length) * turn));
  return place;
}

// How far the hand or the fibre goes, by what changes as they do: in clearances across, and in
// parts of the gaps.
double way_of(const World& world, const State& state, const Pose& by, const Pose& move) noexcept {
  const double lever = state.inserted_length() + world.annulus.fibre_radius;
  const auto more = [](const auto& a, const auto& b) {
    return std::sqrt(std::max(a.squaredNorm(), b.squaredNorm()));
  };
  double way =
      (kAlongTheBore * std::max(std::abs(by[0]), std::abs(move[0])) +
       more(by.segment<2>(1), move.segment<2>(1)) + lever * more(by.tail<2>(), move.tail<2>())) /
      world.annulus.clearance();
  for (const Tangent::Place& place : state.tangent->place)
    if (place.near || place.rubs)
      way += std::abs(place.depth_slope.dot(move)) / std::max(std::abs(place.depth), kLeastGap);
  return way;
}

// What the end moves by as the hand moves `by`.
Pose follow_hand(const World& world, const Tangent& tangent, const Pose& by) noexcept {
  Pose move = tangent.tip_by_command * by;
  if (world.laws.drag) move += tangent.tip_by_last * tangent.last;
  for (const Tangent::Place& place : tangent.place)
    if (place.turned != 0) move += place.turned * place.tip_by_turned;
  return move;
}

// What the spring of a place that slips has across after it has slid so.
double turned_after(const Tangent::Place& place, const Vector3d& slid) noexcept {
  return place.across.dot(slid) + place.longest / (place.longest + place.slid) * place.turned;
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
  const double on = slid.dot(place.stretch) / place.longest;
  const double length = place.longest + place.slid;
  return on > 0 && place.longest + on >= kSlipKept * length &&
         kSlipKept * (place.longest + on) <= length &&
         std::abs(turned_after(place, slid)) <= kStraightSlip * length;
}

}  // namespace

std::optional<TangentStep> along_tangent(const World& world, const State& state,
                                         const Pose& command, double dt) noexcept {
  if (!follows_tangents(world) || !state.linearization) return std::nullopt;
  const Tangent& tangent = *state.tangent;
  if (tangent.reach == 0) return std::nullopt;
  TangentStep next;
  const Pose by = command - state.command;
  if (world.laws.drag && dt != tangent.dt) return std::nullopt;
  next.move = follow_hand(world, tangent, by);
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
  state.tip += next.move;
  Linearization& bore = *state.linearization;
  bore.gradient += bore.hessian.times(PoseVector(next.move));
  bore.at = state.tip;
  state.command = command;
  state.time += dt;
  state.tangent->way = next.way;
  if (world.laws.drag) state.tangent->last = next.move;
  for (std::size_t at = 0; at < kContactPlaces; ++at) {
    Tangent::Place& place = state.tangent->place[at];
    (place.near ? place.depth : state.contact[at].depth) += next.deeper[at];
    if (place.slips) place.turned = turned_after(place, next.slid[at]);
    if (place.rubs) (place.slips ? state.contact[at].stuck : place.stretch) += next.slid[at];
  }
  now.forces.holder = world.holder.stiffness * (state.tip - command);
  now.status = StepStatus::ok;
  now.evaluations = now.iterations = now.halvings = 0;
  now.substeps = 1;
}

void leave_tangent(const World& world, State& state) noexcept {
  if (!state.tangent) return;
  const Tangent tangent = *state.tangent;
  state.tangent.reset();
  if (tangent.way == 0) return;
  const ContactSide side = contact_side(world, state);
  const PoseVector tip(state.tip);
  const auto depth = contact_depths(world, side, tip);
  for (int at = 0; at < kContactPlaces; ++at) {
    const Tangent::Place& place = tangent.place[at];
    ContactState& contact = state.contact[at];
    if (contact.closed) contact.depth = depth[at].value;
    if (!place.rubs) continue;
    Vector3d stretch = place.stretch;
    if (place.slips) {
      const double length = place.longest + place.slid;
      const double longer = place.longer * (contact.depth - place.depth);
      stretch = (1 + longer / place.longest) * stretch.norm() *
                (length * stretch.normalized() + place.turned * place.across).normalized();
    }
    contact.stuck = material_point(world, side, at, tip) - stretch;
  }
}

State before_tangent_step(const World& world, const State& state) noexcept {
  State before = state;
  leave_tangent(world, before);
  if (!world.laws.drag) return before;
  const PoseVector tip(state.tip);
  before.tip -= state.tangent->last;
  const PoseVector from(before.tip);
  const ContactSide side = contact_side(world, before);
  for (int at = 0; at < kContactPlaces; ++at)
    if (state.tangent->place[at].slips)
      before.contact[at].stuck +=
          material_point(world, side, at, from) - material_point(world, side, at, tip);
  return before;
}

void set_tangent(const World& world, const FrozenCoefficients& frozen, const Minimum& found,
                 double dt, State& state) noexcept {
  state.tangent.reset();
  if (!follows_tangents(world) || !found.converged || state.side == EdgeSide::face) return;
  if (std::abs(printed_gap(world, frozen, found.tip)) < kNearPrinted) return;
  Tangent tangent;
  set_range(world, found.tip, tangent);
  if (!(found.tip.x >= tangent.least_x && found.tip.x <= tangent.most_x)) return;
  if (!is_clear(world, found.tip)) return;
  const Compliance compliance(world, frozen, found);
  if (!compliance.holds()) return;
  tangent.determinant = compliance.determinant();
  tangent.tip_by_command = compliance.of(world.holder.stiffness);
  if (world.laws.drag) {
    tangent.tip_by_last = compliance.of(drag_of_last(frozen));
    tangent.last = (found.tip - frozen.from).full();
    tangent.dt = dt;
  }
  const ContactSide side = contact_side(world, state);
  for (int at = 0; at < kContactPlaces; ++at)
    tangent.place[at] = place_of(world, frozen, found, compliance, side, at, state.contact[at]);
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
  const Pose by = now.command - before.command, move = follow_hand(world, *before.tangent, by);
  const double way = before.tangent->way + way_of(world, before, by, move);
  const Pose miss = now.tip - before.tip - move;
  const Numerics& n = world.numerics;
  const double lever = now.inserted_length() + world.annulus.fibre_radius;
  const double tip = miss.head<3>().norm() + lever * miss.tail<2>().norm();
  const double force = (world.holder.stiffness * miss).head<3>().norm();
  const double error = std::max(tip / n.tangent_tip, force / n.tangent_force);
  const double factor = error > 0 ? std::sqrt(kAimedAt / error) : kLonger;
  double& reach = now.tangent->reach;
  reach = std::min(way * std::min(factor, kLonger), kLongestStretch);
  // Up to a fold, where the pose is lost, the determinant falls as the root of the way that is left.
  const double falls = before.tangent->determinant, left = now.tangent->determinant;
  if (left < falls)
    reach = std::min(reach, kToFold * way * left * left / (falls * falls - left * left));
}

}  // namespace ferrule
