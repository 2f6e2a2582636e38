#include "sim/terms/frozen_coefficients.hpp"

#include <algorithm>
#include <cmath>

#include "sim/terms/contact.hpp"
#include "sim/terms/friction.hpp"

namespace ferrule {
namespace {

constexpr double kFarthestPatch = 0.1 * kPatch;  // that a step's is looked ahead for [m]

void freeze_drag(const World& world, double dt, FrozenCoefficients& frozen) noexcept {
  if (!world.laws.drag || dt == 0 || frozen.contact.side == EdgeSide::face) return;
  const double middle = 0.5 * frozen.length, spread = frozen.length / std::sqrt(60.0);
  const Vector2d e = world.oval.stretch * eccentricity(frozen.from, middle);
  const double radius = e.norm();
  const double length = frozen.length > 0 ? frozen.length : 1;
  const DragCoefficients c = drag(*world.laws.drag, world.annulus, radius, length);
  frozen.axial_drag = c.axial / (length * dt);
  frozen.drag_arm = {middle - spread, middle + spread};
  if (frozen.length == 0) return;
  const Vector2d n = radius > 0 ? Vector2d(e / radius) : Vector2d(Vector2d::UnitX());
  const Matrix2d across =
      c.tangential * Matrix2d::Identity() + (c.radial - c.tangential) * n * n.transpose();
  frozen.drag_per_move = 0.5 / dt * across;
  // The arms' mean is the middle, that of their squares middle^2 + spread^2.
  const Matrix2d both = 2 * frozen.drag_per_move;
  frozen.stiffness.ee += both;
  frozen.stiffness.et += middle * both;
  frozen.stiffness.tt += (middle * middle + spread * spread) * both;
}

void freeze_flow(const World& world, const State& state, double dt,
                 FrozenCoefficients& frozen) noexcept {
  if (!world.laws.flow || frozen.contact.side == EdgeSide::face) return;
  const double c = world.annulus.clearance() + world.annulus.roughness, l = frozen.length;
  // The mean of the square along the straight axis.
  const PoseVector tip = world.oval.stretched(state.tip);
  const Vector2d from = tip.e, to = eccentricity(tip, l);
  const double square = (from.squaredNorm() + from.dot(to) + to.squaredNorm()) / (3 * c * c);
  frozen.flow = FlowStep(*world.laws.flow, world.annulus, world.profile.length, l,
                         std::min(1.0, square), state.air, dt);
}

// Of what bends, by the velocity that inertia has at the step's end, relative to the hand's.
void freeze_damping(const World& world, const State& state, double dt,
                    FrozenCoefficients& frozen) noexcept {
  const Matrix5& damping = world.holder.damping;
  if (damping(1, 1) == 0) return;
  Pose drift = (frozen.command.full() - state.command) / dt;
  if (frozen.second_order) drift += (state.tip - state.tip_before) / (2 * dt);
  frozen.damping_rate = (frozen.second_order ? 1.5 : 1) / dt;
  frozen.damping_drift = drift;
  const Wrench force = damping * drift;
  frozen.stiffness += PoseMatrix(frozen.damping_rate * damping);
  frozen.load += PoseVector(force);
  frozen.load_scale += force.head<3>().norm();
}

void freeze_inertia(const World& world, const State& state, double dt,
                    FrozenCoefficients& frozen) noexcept {
  if (world.dynamics != Dynamics::inertial || dt == 0) return;
  frozen.inertial = true;
  frozen.second_order = world.numerics.integrator == Integrator::bdf2 && state.dt_before > 0 &&
                        std::abs(state.dt_before - dt) <= 1e-9 * dt;
  // Mass times the square of the integrator's coefficient over dt^2, and the move without forces.
  Matrix5 inertia = 1 / (dt * dt) * world.holder.mass;
  Pose coasting = dt * state.velocity;
  if (frozen.second_order) {
    inertia *= 2.25;
    coasting = (state.tip - state.tip_before) / 3 +
               2 * dt / 9 * (4 * state.velocity - state.velocity_before);
  }
  const Pose force = inertia * coasting;
  frozen.stiffness += PoseMatrix(inertia);
  frozen.load = PoseVector(frozen.load.full() + force);
  frozen.load_scale += force.head<3>().norm();
  freeze_damping(world, state, dt, frozen);
}

// The side's friction has the patch of where the step ends, if the end goes as the hand does: a
// spring that grows with it holds no more than before.
void freeze_patch(const World& world, const State& state, FrozenCoefficients& frozen) noexcept {
  FrozenFriction& friction = frozen.friction[kSide];
  const double move = frozen.command.x - state.command[0];
  const double before = side_share(world, frozen, frozen.from);
  const double past = frozen.contact.past_mouth(frozen.from, world.annulus.fibre_radius);
  friction.patch = PatchShare(past - std::clamp(move, -kFarthestPatch, kFarthestPatch)).value;
  if (!(friction.patch > before)) return;
  const Vector3d slip = material_point(world, frozen.contact, kSide, frozen.from) - friction.stuck;
  friction.stuck += (1 - before / friction.patch) * slip;
}

}  // namespace

FrozenCoefficients freeze(const World& world, const State& state, const Pose& command,
                          double dt) noexcept {
  FrozenCoefficients frozen;
  frozen.command = command;
  frozen.from = state.tip;
  frozen.stiffness = PoseMatrix(world.holder.stiffness);
  const PoseVector weight = world.holder.weight;
  frozen.load = frozen.stiffness.times(frozen.command - frozen.from);
  frozen.load_scale = frozen.load.length() + std::abs(weight.e.x());
  frozen.load += weight;
  frozen.length = std::min(state.inserted_length(), world.profile.length);
  frozen.contact = contact_side(world, state.tip, state.side);
  frozen.bridge = state.bridge;
  freeze_drag(world, dt, frozen);
  freeze_flow(world, state, dt, frozen);
  freeze_inertia(world, state, dt, frozen);
  for (std::size_t place = 0; place < kContactPlaces; ++place)
    frozen.branch[place] = state.contact[place].branch;
  const bool both = state.contact[kEnd].closed && state.contact[kSide].closed;
  if (both && std::holds_alternative<printed::Adhesion>(world.laws.adhesion))
    frozen.adhesion_share = 0.5;
  if (!friction_law(world.laws) || (!state.contact[kEnd].closed && !state.contact[kSide].closed))
    return frozen;

  const bool shared = both && std::holds_alternative<printed::Friction>(world.laws.friction);
  const auto depths = contact_depths(world, frozen.contact, state.tip);
  for (std::size_t place = 0; place < kContactPlaces; ++place) {
    const ContactState& contact = state.contact[place];
    if (!contact.closed || depths[place].value == -INFINITY) continue;
    FrozenFriction& friction = frozen.friction[place];
    const Vector2d tilt = state.tip.tail<2>();
    const Vector3d n = depths[place].normal(tilt).normalized();
    friction.depth_slope = depths[place].by_pose(tilt);
    friction.stuck = contact.stuck;
    friction.tangential = Matrix3d::Identity() - n * n.transpose();
    friction.arm = place == kSide ? -state.tip[0] : 0.0;
    friction.patch = 1;
    if (place == kSide) freeze_patch(world, state, frozen);
    friction.share = friction.patch * (shared ? 0.5 : 1.0);
    static_cast<FrictionLimit&>(friction) = friction_limit(
        world, friction, friction_radius(world, depths[place].value, contact.branch));
    friction.acts = friction.limit > 0;
  }
  return frozen;
}

}  // namespace ferrule
