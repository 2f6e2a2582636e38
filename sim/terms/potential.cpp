#include "sim/terms/potential.hpp"

#include <algorithm>
#include <cmath>

#include "sim/terms/particle_depth.hpp"

namespace ferrule {
namespace {

// From the surface that touches to the fibre's axis [m]. At two points the end and the side touch
// on opposite sides of the fibre.
Vector2d offset(const World& world, const ContactSide& side, int place) noexcept {
  return -world.annulus.fibre_radius * (place == kEnd ? side.outward : side.mouth_outward);
}
Vector2d offset(const World& world, const FrozenCoefficients& frozen, int place) noexcept {
  return offset(world, frozen.contact, place);
}

// Material point of a contact: on the fibre's surface along x, on its axis across.
Vector3d material_point(const PoseVector& tip, double arm, const Vector2d& offset) noexcept {
  const Vector2d e = eccentricity(tip, arm);
  return {tip.x + offset.dot(tip.t), e.x(), e.y()};
}

// Huber's potential of the tangential displacement: elastic while it sticks, constant force beyond.
Vector3d friction_force(const FrozenFriction& friction, const Vector3d& material) noexcept {
  const Vector3d slip = friction.tangential * (material - friction.stuck);
  const double elastic = friction.stiffness * slip.norm();
  return elastic <= friction.limit ? Vector3d(-friction.stiffness * slip)
                                   : Vector3d(-friction.limit * slip.normalized());
}

void add_friction(Energy& total, const FrozenFriction& friction, const Vector2d& offset,
                  const PoseVector& tip) noexcept {
  const Vector3d slip =
      friction.tangential * (material_point(tip, friction.arm, offset) - friction.stuck);
  const double length = slip.norm();
  Vector3d slope = friction.stiffness * slip;
  Matrix3d curve = friction.stiffness * friction.tangential;
  double value = 0.5 * friction.stiffness * length * length;
  if (friction.stiffness * length > friction.limit) {
    const Vector3d direction = slip / length;
    value = friction.limit * (length - 0.5 * friction.limit / friction.stiffness);
    slope = friction.limit * direction;
    curve = friction.limit / length * (friction.tangential - direction * direction.transpose());
  }
  total.value += value;
  total.value_scale += value;
  total.force_scale += slope.norm();
  total.add_point(friction.arm, offset, slope, curve);
}

ContactForce push_at(const World& world, double depth) noexcept {
  const std::optional<Wall>& law = world.laws.wall;
  return law && depth != -INFINITY ? wall(*law, depth) : ContactForce{};
}

AdhesionForce pull_at(const World& world, double depth, int branch) noexcept {
  return depth != -INFINITY ? adhesion_force(world.laws, depth, branch) : AdhesionForce{};
}

constexpr double kFarthestPatch = 0.1 * kPatch;  // that a step's is looked ahead for [m]

// The share of the side's patch that the end leaves, by the length of the side past the mouth.
struct PatchShare {
  double value, slope, curve;  // [-], [1/m], [1/m^2]

  explicit PatchShare(double length) noexcept {
    const double p = std::clamp(length / kPatch, 0.0, 1.0), rest = 1 - p;
    value = p * p * p * (10 - p * (15 - 6 * p));
    slope = 30 * p * p * rest * rest / kPatch;
    curve = 60 * p * rest * (1 - 2 * p) / (kPatch * kPatch);
  }
};

// What the end cuts off the side's contact: its energy U times the share S of the length, which
// grows by -1 with x and by `ahead` with the tilts.
void cut_patch(Potential& there, const PatchShare& share, const Vector2d& ahead,
               const PoseVector& tip) noexcept {
  ContactForce &wall = there.push[kSide], &adhesion = there.pull[kSide];
  there.push_out = share.slope * wall.potential;
  there.pull_out = share.slope * adhesion.potential;
  const double out = there.push_out + there.pull_out;
  const double bend = share.curve * (wall.potential + adhesion.potential);
  // S' dU, by the eccentricity at the mouth.
  const Vector2d turn =
      share.slope * (wall.force + adhesion.force) * there.depth[kSide].slope.tail<2>();
  const double along = turn.dot(tip.t), arm = -tip.x;
  Energy& bore = there.bore;
  bore.gradient.x -= out;
  bore.gradient.t += out * ahead;
  bore.force_scale += std::abs(there.push_out) + std::abs(there.pull_out);
  const Matrix2d mixed = turn * ahead.transpose();
  bore.hessian.xx += bend + 2 * along;
  bore.hessian.xe -= turn;
  bore.hessian.xt -= (bend + along) * ahead + arm * turn;
  bore.hessian.et += mixed;
  bore.hessian.tt += bend * ahead * ahead.transpose() + arm * (mixed + mixed.transpose());
  for (ContactForce* part : {&wall, static_cast<ContactForce*>(&adhesion)}) {
    part->potential *= share.value;
    part->force *= share.value;
    part->slope *= share.value;
  }
}

FrictionLimit friction_limit(const World& world, const FrozenFriction& friction,
                             const ContactRadius& radius) noexcept {
  const double a = radius.value;
  if (!(a > 0)) return {};
  const Friction& law = *friction_law(world.laws);
  const double limit = friction.share * ferrule::friction(law, a);
  return {limit, friction.patch * sticking_stiffness(law, a),
          friction_exponent(law, a) * limit / a * radius.per_depth};
}

// Drag along x over the step (FrozenCoefficients::axial_drag).
AxialForce axial_drag(const FrozenCoefficients& frozen, const PoseVector& tip) noexcept {
  const double before = std::max(0.0, -frozen.from.x), now = std::max(0.0, -tip.x);
  const double k = frozen.axial_drag, more = now - before;
  return {k * more * more * (now + 2 * before) / 6, 0.5 * k * more * (now + before), k * now};
}

// Of the fluid ahead of the end, over the step.
AxialForce flow_ahead(const FrozenCoefficients& frozen, const PoseVector& tip) noexcept {
  return tip.x < 0 ? frozen.flow.at(-tip.x) : AxialForce{};
}

void add_axial(Energy& total, const AxialForce& axial) noexcept {
  total.value += axial.energy;
  total.value_scale += std::abs(axial.energy);
  total.force_scale += std::abs(axial.force);
  total.gradient.x -= axial.force;
  total.hessian.xx += axial.stiffness;
}

bool particle_acts(const World& world, const FrozenCoefficients& frozen) noexcept {
  return world.laws.particle && frozen.contact.side == EdgeSide::throat;
}

void add_particle(Energy& total, const World& world, const PoseVector& tip) noexcept {
  const ParticleDepth there = particle_depth(world, tip);
  if (!(there.value > 0)) return;
  const ContactForce push = particle_push(*world.laws.particle, there.value);
  total.value += push.potential;
  total.value_scale += push.potential;
  total.force_scale += push.force;
  total.gradient += push.force * there.slope;
  total.hessian += push.force * there.curve;
  add_square(total.hessian, push.slope, there.slope);
}

void add_frictions(Energy& total, const World& world, const FrozenCoefficients& frozen,
                   const PoseVector& tip) noexcept {
  for (int place = 0; place < kContactPlaces; ++place) {
    const FrozenFriction& friction = frozen.friction[static_cast<std::size_t>(place)];
    if (friction.acts) add_friction(total, friction, offset(world, frozen, place), tip);
  }
}

// Holder, weight, inertia, drag and friction: what a step adds to the forces in the bore.
void add_step(Energy& total, const World& world, const FrozenCoefficients& frozen,
              const PoseVector& tip) noexcept {
  const PoseVector move = tip - frozen.from;
  const PoseVector pull = frozen.stiffness.times(move);
  const double sprung = 0.5 * move.dot(pull), loaded = frozen.load.dot(move);
  total.value += sprung - loaded;
  total.value_scale += sprung + std::abs(loaded);
  total.force_scale += pull.length() + frozen.load_scale;
  total.gradient += pull;
  total.gradient -= frozen.load;
  total.hessian += frozen.stiffness;
  if (frozen.axial_drag > 0) add_axial(total, axial_drag(frozen, tip));
  if (frozen.flow.acts()) add_axial(total, flow_ahead(frozen, tip));
  add_frictions(total, world, frozen, tip);
}

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

// Where the fibre is whole around, in the round bore that an oval one is stretched to.
PoseVector whole(const World& world, const PoseVector& tip) noexcept {
  PoseVector at = world.oval.stretched(tip);
  at.x += world.end.behind;
  at.e += world.end.behind * at.t;
  return at;
}
PoseVector by_tip(const World& world, PoseVector gradient) noexcept {
  gradient.t += world.end.behind * gradient.e;
  return world.oval.by_pose(gradient);
}
PoseMatrix by_tip(const World& world, PoseMatrix m) noexcept {
  const double arm = world.end.behind;
  m.tt += arm * (m.et + m.et.transpose() + arm * m.ee);
  m.et += arm * m.ee;
  m.xt += arm * m.xe;
  return world.oval.by_pose(m);
}

// The length that the printed laws act along.
double printed_length(const World& world, const FrozenCoefficients& frozen) noexcept {
  return std::max(0.0, frozen.length - world.end.behind);
}

void add_surface(Energy& total, SurfaceGradients& by_term, const World& world,
                 const FrozenCoefficients& frozen, const PoseVector& tip) noexcept {
  const double length = printed_length(world, frozen);
  if (world.oval.round() && world.end.behind == 0) {
    add_surface_forces(total, by_term, world, length, frozen.bridge, tip);
    return;
  }
  Energy there;
  SurfaceGradients terms;
  add_surface_forces(there, terms, world, length, frozen.bridge, whole(world, tip));
  total.value += there.value;
  total.value_scale += there.value_scale;
  total.force_scale += there.force_scale;
  total.gradient += by_tip(world, there.gradient);
  total.hessian += by_tip(world, there.hessian);
  for (std::size_t i = 0; i < kSurfaceTerms; ++i) by_term[i] += by_tip(world, terms[i]);
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

std::array<FrictionLimit, kContactPlaces> friction_limits(const World& world,
                                                          const FrozenCoefficients& frozen,
                                                          const Potential& there) noexcept {
  std::array<FrictionLimit, kContactPlaces> limits;
  for (std::size_t at = 0; at < kContactPlaces; ++at) {
    const double depth = there.depth[at].value;
    if (frozen.friction[at].acts && depth != -INFINITY)
      limits[at] =
          friction_limit(world, frozen.friction[at], friction_radius(world, depth, there.pull[at]));
  }
  return limits;
}

double sticking_stiffness(const World& world, const FrozenCoefficients& frozen,
                          const PoseVector& tip, const Potential& there, int place) noexcept {
  const auto at = static_cast<std::size_t>(place);
  const double depth = there.depth[at].value;
  const double a = depth == -INFINITY ? 0.0 : friction_radius(world, depth, there.pull[at]).value;
  if (!(a > 0)) return 0;
  const double patch = place == kSide ? side_share(world, frozen, tip) : 1.0;
  return patch * sticking_stiffness(*friction_law(world.laws), a);
}

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

Energy without_friction(const FrozenCoefficients& frozen, const PoseVector& tip,
                        const PoseVector& bore_gradient, const PoseMatrix& bore_hessian) noexcept {
  Energy total;
  total.gradient = bore_gradient;
  total.gradient += frozen.stiffness.times(tip - frozen.from);
  total.gradient -= frozen.load;
  total.hessian = bore_hessian;
  total.hessian += frozen.stiffness;
  if (frozen.axial_drag > 0) add_axial(total, axial_drag(frozen, tip));
  if (frozen.flow.acts()) add_axial(total, flow_ahead(frozen, tip));
  return total;
}

double side_share(const World& world, const FrozenCoefficients& frozen,
                  const PoseVector& tip) noexcept {
  const double past = frozen.contact.past_mouth(tip, world.annulus.fibre_radius);
  return past < kPatch ? PatchShare(past).value : 1.0;
}

double printed_arm(const World& world, const FrozenCoefficients& frozen) noexcept {
  const double length = printed_length(world, frozen);
  const bool acts = frozen.contact.side == EdgeSide::throat && length > 0;
  return acts && has_printed_forces(world) ? world.end.behind + 0.5 * length : 0;
}

double printed_gap(const World& world, const FrozenCoefficients& frozen,
                   const PoseVector& tip) noexcept {
  const double arm = printed_arm(world, frozen);
  if (arm == 0) return INFINITY;
  return world.annulus.clearance() - eccentricity(world.oval.stretched(tip), arm).norm();
}

std::array<NonsmoothTerm, kNonsmoothTerms> nonsmooth_terms(const World& world,
                                                           const FrozenCoefficients& frozen,
                                                           const PoseVector& tip,
                                                           double side_share) noexcept {
  std::array<NonsmoothTerm, kNonsmoothTerms> laws;
  const auto depths = contact_depths(world, frozen.contact, tip);
  for (std::size_t place = 0; place < kContactPlaces; ++place) {
    const ContactDepth& depth = depths[place];
    if (depth.value == -INFINITY) continue;
    const ContactForce push = push_at(world, depth.value);
    const AdhesionForce pull = pull_at(world, depth.value, frozen.branch[place]);
    const double share = place == kSide ? side_share : 1.0;
    const double adhesion = share * frozen.adhesion_share;
    laws[place] = {share,
                   true,
                   depth.value,
                   depth.by_pose(tip.t),
                   share * push.potential + adhesion * pull.potential,
                   share * push.force + adhesion * pull.force,
                   share * push.slope + adhesion * pull.slope};
  }
  if (particle_acts(world, frozen)) {
    const ParticleDepth there = particle_depth(world, tip);
    const ContactForce push = particle_push(*world.laws.particle, there.value);
    laws[kInParticle] = {1, true, there.value, there.slope, push.potential, push.force, push.slope};
  }
  const double arm = printed_arm(world, frozen);
  if (arm == 0) return laws;
  const double clearance = world.annulus.clearance(), length = printed_length(world, frozen);
  const Radial middle(eccentricity(world.oval.stretched(tip), arm), clearance);
  const double gap = clearance - middle.eccentricity;
  const Vector2d out = world.oval.stretch * middle.normal;
  const LineForce force = printed_forces(world, gap);
  laws[kPrintedWell] = {1,
                        true,
                        -gap,
                        {0, out, arm * out},
                        length * force.potential,
                        length * force.force,
                        -length * force.slope};
  return laws;
}

Vector3d material_point(const World& world, const ContactSide& side, int place,
                        const PoseVector& tip) noexcept {
  return material_point(tip, place == kSide ? -tip.x : 0.0, offset(world, side, place));
}

Vector3d elastic_slip_by(const World& world, const FrozenCoefficients& frozen, int place,
                         const PoseVector& move) noexcept {
  const FrozenFriction& friction = frozen.friction[static_cast<std::size_t>(place)];
  return friction.tangential * material_point(move, friction.arm, offset(world, frozen, place));
}

Vector3d elastic_slip(const World& world, const FrozenCoefficients& frozen, int place,
                      const PoseVector& tip) noexcept {
  const FrozenFriction& friction = frozen.friction[static_cast<std::size_t>(place)];
  return friction.tangential *
         (material_point(tip, friction.arm, offset(world, frozen, place)) - friction.stuck);
}

PoseVector friction_direction(const World& world, const FrozenCoefficients& frozen, int place,
                              const Vector3d& slip) noexcept {
  const Vector3d direction = slip.normalized();
  const Vector2d across = direction.tail<2>();
  return {direction.x(), across,
          direction.x() * offset(world, frozen, place) +
              frozen.friction[static_cast<std::size_t>(place)].arm * across};
}

void add_friction_about(Energy& total, const World& world, const FrozenCoefficients& frozen,
                        int place, const Vector3d& slip, const Vector3d& about) noexcept {
  const FrozenFriction& friction = frozen.friction[static_cast<std::size_t>(place)];
  Vector3d slope = friction.stiffness * about;
  Matrix3d curve = friction.stiffness * friction.tangential;
  if (friction.slides(about)) {
    const double over = 1 / about.norm();
    const Vector3d direction = over * about;
    slope = friction.limit * direction;
    curve = friction.limit * over * (friction.tangential - direction * direction.transpose());
  }
  slope += curve * (slip - about);
  total.add_point(friction.arm, offset(world, frozen, place), slope, curve);
}

Potential::Potential(const World& world, const FrozenCoefficients& frozen,
                     const PoseVector& tip) noexcept
    : depth(contact_depths(world, frozen.contact, tip)),
      push{push_at(world, depth[kEnd].value), push_at(world, depth[kSide].value)},
      pull{pull_at(world, depth[kEnd].value, frozen.branch[kEnd]),
           pull_at(world, depth[kSide].value, frozen.branch[kSide])} {
  if (frozen.adhesion_share != 1)
    for (AdhesionForce& shared : pull) {
      shared.potential *= frozen.adhesion_share;
      shared.force *= frozen.adhesion_share;
      shared.slope *= frozen.adhesion_share;
    }
  const double r = world.annulus.fibre_radius, past = frozen.contact.past_mouth(tip, r);
  if (past > 0 && past < kPatch)
    cut_patch(*this, PatchShare(past), r * frozen.contact.mouth_outward, tip);
  const bool inserted = frozen.contact.side == EdgeSide::throat;
  if (inserted) add_surface(bore, surface, world, frozen, tip);
  if (world.laws.meniscus && inserted && tip.x < 0) {
    const double inwards = meniscus(*world.laws.meniscus, world.annulus.fibre_radius);
    bore.value += inwards * tip.x;
    bore.value_scale -= inwards * tip.x;
    bore.gradient.x += inwards;
    bore.force_scale += inwards;
  }
  for (std::size_t at = 0; at < kContactPlaces; ++at) {
    bore.value += push[at].potential + pull[at].potential;
    bore.value_scale += push[at].potential + std::abs(pull[at].potential);
    const double force = push[at].force + pull[at].force;
    const double stiffness = push[at].slope + pull[at].slope;
    if (force == 0 && stiffness == 0) continue;
    bore.force_scale += push[at].force + std::abs(pull[at].force);
    depth[at].add_to(bore, tip.t, force, stiffness);
  }
  if (particle_acts(world, frozen)) add_particle(bore, world, tip);
  static_cast<Energy&>(*this) = bore;
  add_step(*this, world, frozen, tip);
}

void Potential::follow(const PoseVector& move, const PoseVector& tip) noexcept {
  bore.gradient += bore.hessian.times(move);
  for (std::size_t at = 0; at < kContactPlaces; ++at) {
    if (depth[at].value == -INFINITY) continue;
    const double deeper = depth[at].by_pose(tip.t).dot(move);
    depth[at].value += deeper;
    push[at].force += push[at].slope * deeper;
    pull[at].force += pull[at].slope * deeper;
    pull[at].radius += pull[at].radius_slope * deeper;
  }
}

void forces(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
            const Potential& there, Breakdown& b) noexcept {
  const Vector3d end = tip.position();
  b.holder = PoseMatrix(world.holder.stiffness).times(tip - frozen.command).full();
  if (frozen.damping_rate > 0)
    b.holder += world.holder.damping *
                (frozen.damping_rate * (tip - frozen.from) - frozen.damping_drift).full();
  b[Term::gravity][0] = {{0, world.holder.weight[1], 0}, end + world.holder.weight_arm};

  const double length = -tip.x, inverse = 1 / length;
  for (std::size_t i = 0; i < kSurfaceTerms && length > 0; ++i) {
    const PoseVector& g = there.surface[i];
    const Vector2d mouth = -inverse * g.t;
    const Vector2d inside = -g.e - mouth;
    TermForces& term = b[kSurfaceTermTable[i]];
    term[0] = {{-g.x, inside.x(), inside.y()}, end};
    term[1] = {across(mouth), end + Vector3d(length, length * tip.t.x(), length * tip.t.y())};
  }
  if (world.laws.meniscus && frozen.contact.side == EdgeSide::throat && tip.x < 0)
    b[Term::meniscus][0] = {{-meniscus(*world.laws.meniscus, world.annulus.fibre_radius), 0, 0},
                            end};
  if (frozen.axial_drag > 0) {
    const double axial = 0.5 * axial_drag(frozen, tip).force;
    const PoseVector moved = tip - frozen.from;
    for (std::size_t i = 0; i < 2; ++i) {
      const double arm = frozen.drag_arm[i];
      const Vector2d e = eccentricity(tip, arm);
      const Vector2d sideways = -(frozen.drag_per_move * (moved.e + arm * moved.t));
      b[Term::drag][i] = {{axial, sideways.x(), sideways.y()}, {tip.x + arm, e.x(), e.y()}};
    }
  }
  if (frozen.flow.acts()) b[Term::flow][0] = {{flow_ahead(frozen, tip).force, 0, 0}, end};
  if (particle_acts(world, frozen)) {
    const ParticleDepth touch = particle_depth(world, tip);
    const double push = particle_push(*world.laws.particle, touch.value).force;
    b[Term::particle][0] = {-push * touch.slope.position(), touch.point};
  }
  for (int place = 0; place < kContactPlaces; ++place) {
    const auto at = static_cast<std::size_t>(place);
    const ContactDepth& depth = there.depth[at];
    if (depth.value == -INFINITY) continue;
    const Vector3d normal = depth.normal(tip.t);
    b[Term::wall][at] = {there.push[at].force * normal, depth.point};
    b[Term::adhesion][at] = {there.pull[at].force * normal, depth.point};
    const FrozenFriction& friction = frozen.friction[at];
    if (!friction.acts) continue;
    const Vector2d to_axis = offset(world, frozen, place);
    const Vector2d surface = eccentricity(tip, friction.arm) - to_axis;
    b[Term::friction][at] = {friction_force(friction, material_point(tip, friction.arm, to_axis)),
                             {tip.x + friction.arm, surface.x(), surface.y()}};
  }
  if (there.push_out == 0 && there.pull_out == 0) return;
  const Vector2d rim = tip.e + world.annulus.fibre_radius * frozen.contact.mouth_outward;
  for (const auto& [term, force] :
       {std::pair(Term::wall, there.push_out), std::pair(Term::adhesion, there.pull_out)}) {
    PointForce& at_end = b[term][kEnd];
    at_end.force.x() += force;
    at_end.point = {tip.x, rim.x(), rim.y()};
  }
}

Contacts contacts(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                  const Potential& there) noexcept {
  Contacts now;
  now.bridge =
      frozen.contact.side == EdgeSide::throat && bridge_at(world, frozen.bridge, whole(world, tip));
  for (int place = 0; place < kContactPlaces; ++place) {
    const auto at = static_cast<std::size_t>(place);
    const double depth = there.depth[at].value;
    if (depth == -INFINITY) continue;
    ContactState& contact = now.contact[at];
    contact.closed = depth > 0 || there.pull[at].radius > 0;
    contact.depth = contact.closed ? depth : 0.0;
    contact.branch = there.pull[at].branch;
  }
  return now;
}

bool contact_set_changed(const State& before, const Contacts& now) noexcept {
  for (std::size_t place = 0; place < kContactPlaces; ++place)
    if (before.contact[place].closed != now.contact[place].closed ||
        before.contact[place].branch != now.contact[place].branch)
      return true;
  return before.bridge != now.bridge;
}

}  // namespace ferrule
