#include "sim/potential.hpp"

namespace ferrule {
namespace {

using Eigen::Matrix2d;

// Calls visit(breakdown slot, force) for each surface law of `form`, at gap h.
template <class Visit>
void each_surface_law(const World& world, Form form, double h, bool bridge,
                      const Visit& visit) noexcept {
  if (world.van_der_waals && world.van_der_waals->form == form)
    visit(&Breakdown::van_der_waals, van_der_waals(*world.van_der_waals, world.annulus, h));
  if (world.electrostatic && world.electrostatic->form == form)
    visit(&Breakdown::electrostatic, electrostatic(*world.electrostatic, world.annulus, h));
  if (world.capillary && world.capillary->form == form)
    visit(&Breakdown::capillary, capillary(*world.capillary, world.annulus, h, bridge));
}

bool has_surface_law(const World& world, Form form) noexcept {
  return (world.van_der_waals && world.van_der_waals->form == form) ||
         (world.electrostatic && world.electrostatic->form == form) ||
         (world.capillary && world.capillary->form == form);
}

// Inserted length of the pose itself, and its derivative by x.
double inserted(const World& world, const Pose& tip) noexcept {
  return std::clamp(-tip[0], 0.0, world.profile.length);
}
double inserted_slope(const World& world, const Pose& tip) noexcept {
  return tip[0] < 0 && -tip[0] < world.profile.length ? -1 : 0;
}

// The smallest gap along the inserted length: at one of its ends, the distance of a straight line
// from the axis being convex.
double smallest_gap(const World& world, const Pose& tip) noexcept {
  return world.annulus.clearance() -
         std::max(eccentricity(tip, 0).norm(), eccentricity(tip, inserted(world, tip)).norm());
}

// Adds the surface forces of one form. Corrected ones act along the length of the pose itself,
// which makes them pull along x; printed ones along that of the step's start.
void add_surface(Potential& total, const World& world, const Lagged& lagged, Form form,
                 const Pose& tip, Breakdown* breakdown) noexcept {
  const bool follows = form == Form::corrected;
  const double length = follows ? inserted(world, tip) : lagged.length;
  const double slope = follows ? inserted_slope(world, tip) : 0;
  const double c = world.annulus.clearance();
  double value = 0;              // per length
  Pose gradient = Pose::Zero();  // of that
  for (int n = 0; n < world.quadrature.order; ++n) {
    const double node = world.quadrature.node[static_cast<std::size_t>(n)];
    const double weight = world.quadrature.weight[static_cast<std::size_t>(n)];
    const double arm = node * length;
    const Vector2d axis = eccentricity(tip, arm);
    const Radial radial(axis, c);
    LineForce sum;
    each_surface_law(world, form, c - radial.eccentricity, lagged.bridge,
                     [&](PointForce Breakdown::*slot, const LineForce& law) {
                       sum.potential += law.potential;
                       sum.force += law.force;
                       sum.slope += law.slope;
                       if (!breakdown) return;
                       Vector3d f = -weight * length * law.force * across(radial.normal);
                       f.x() = -slope * weight *
                               (law.potential + arm * law.force * radial.normal.dot(tip.tail<2>()));
                       // Each law acts at the mean of its nodes, weighed by their forces.
                       PointForce& to = breakdown->*slot;
                       const Vector3d point(tip[0] + arm, axis.x(), axis.y());
                       const double before = to.force.tail<2>().norm(), now = f.tail<2>().norm();
                       if (before + now > 0)
                         to.point = (before * to.point + now * point) / (before + now);
                       to.force += f;
                     });
    // Chain rule through the eccentricity, whose gradient by the pose is n J with J = (by_x, 1,
    // arm).
    const Vector2d pull = weight * sum.force * radial.normal;
    const Matrix2d stiff = weight * (sum.force * radial.curving -
                                     sum.slope * radial.normal * radial.normal.transpose());
    const double arm_per_x = node * slope;
    const Vector2d by_x = arm_per_x * tip.tail<2>();
    value += weight * sum.potential;
    gradient[0] += pull.dot(by_x);
    gradient.segment<2>(1) += pull;
    gradient.tail<2>() += arm * pull;
    const Matrix2d k = length * stiff;
    total.hessian.block<2, 2>(1, 1) += k;
    total.hessian.block<2, 2>(1, 3) += arm * k;
    total.hessian.block<2, 2>(3, 1) += arm * k;
    total.hessian.block<2, 2>(3, 3) += arm * arm * k;
    if (follows) {
      const Vector2d kx = k * by_x, cross = arm * kx + length * arm_per_x * pull;
      total.hessian(0, 0) += by_x.dot(kx);
      total.hessian.block<1, 2>(0, 1) += kx.transpose();
      total.hessian.block<2, 1>(1, 0) += kx;
      total.hessian.block<1, 2>(0, 3) += cross.transpose();
      total.hessian.block<2, 1>(3, 0) += cross;
    }
    total.force_scale += std::abs(weight * length * sum.force);
  }
  total.value += length * value;
  total.value_scale += std::abs(length * value);
  total.gradient += length * gradient;
  if (!follows) return;
  total.gradient[0] += slope * value;
  total.hessian.row(0) += slope * gradient.transpose();
  total.hessian.col(0) += slope * gradient;
  total.force_scale += std::abs(slope * value);
}

// Material point of a contact: on the fibre's surface along x, on its axis across.
Vector3d material_point(const World& world, const Lagged& lagged, const Pose& tip,
                        double arm) noexcept {
  const double r = world.annulus.fibre_radius;
  Vector3d p;
  p << tip[0] - r * lagged.contact.outward.dot(tip.tail<2>()), eccentricity(tip, arm);
  return p;
}

// Huber's potential of the tangential displacement: elastic while stuck, constant force beyond.
Vector3d friction_force(const LaggedFriction& friction, const Vector3d& material) noexcept {
  const Vector3d stretch = friction.tangential * (material - friction.stuck);
  const double elastic = friction.stiffness * stretch.norm();
  return elastic <= friction.limit ? Vector3d(-friction.stiffness * stretch)
                                   : Vector3d(-friction.limit * stretch.normalized());
}

// Adds a potential of the point p = (x - r outward.tilt, axis at `arm`), given its derivatives by
// p.
void add_point(Potential& total, const World& world, const Lagged& lagged, double arm,
               const Vector3d& gradient, const Eigen::Matrix3d& hessian, bool on_axis) noexcept {
  // p = (x - r outward.tilt, y + arm tilt): the columns of its Jacobian, tilts last.
  const Vector2d lean = on_axis ? Vector2d(Vector2d::Zero())
                                : Vector2d(-world.annulus.fibre_radius * lagged.contact.outward);
  const Vector2d sideways = gradient.tail<2>();
  total.gradient.head<3>() += gradient;
  total.gradient.tail<2>() += gradient[0] * lean + arm * sideways;
  total.hessian.topLeftCorner<3, 3>() += hessian;
  const Eigen::Matrix<double, 3, 2> mixed =
      hessian.col(0) * lean.transpose() + arm * hessian.rightCols<2>();
  total.hessian.topRightCorner<3, 2>() += mixed;
  total.hessian.bottomLeftCorner<2, 3>() += mixed.transpose();
  total.hessian.bottomRightCorner<2, 2>() += lean * mixed.row(0) + arm * mixed.bottomRows<2>();
  total.force_scale += gradient.norm();
}

void add_friction(Potential& total, const World& world, const Lagged& lagged,
                  const LaggedFriction& friction, const Pose& tip) noexcept {
  const Vector3d stretch =
      friction.tangential * (material_point(world, lagged, tip, friction.arm) - friction.stuck);
  const double length = stretch.norm();
  if (friction.stiffness * length <= friction.limit) {
    total.value += 0.5 * friction.stiffness * length * length;
    add_point(total, world, lagged, friction.arm, friction.stiffness * stretch,
              friction.stiffness * friction.tangential, false);
  } else {
    const Vector3d direction = stretch / length;
    total.value += friction.limit * (length - 0.5 * friction.limit / friction.stiffness);
    add_point(total, world, lagged, friction.arm, friction.limit * direction,
              friction.limit / length * (friction.tangential - direction * direction.transpose()),
              false);
  }
}

// Displacement of the axis at `arm` since the step's start.
Vector3d drag_move(const Lagged& lagged, const Pose& tip, double arm) noexcept {
  const Pose move = tip - lagged.drag_from;
  Vector3d moved;
  moved << move[0], eccentricity(move, arm);
  return moved;
}

AdhesionForce shared_adhesion(const World& world, const Lagged& lagged, int place,
                              double depth) noexcept {
  if (!world.adhesion) return {};
  AdhesionForce force =
      adhesion(*world.adhesion, depth, lagged.branch[static_cast<std::size_t>(place)]);
  const double share = lagged.adhesion_share;
  force.potential *= share;
  force.force *= share;
  force.slope *= share;
  return force;
}

ContactForce wall_force(const World& world, double depth) noexcept {
  return world.wall ? wall(*world.wall, depth) : ContactForce{};
}

void lag_drag(const World& world, const State& state, double dt, Lagged& lagged) noexcept {
  if (!world.drag || lagged.length == 0 || dt == 0) return;
  const double middle = 0.5 * lagged.length, spread = lagged.length / std::sqrt(60.0);
  const Vector2d e = eccentricity(state.tip, middle);
  const DragCoefficients c = drag(*world.drag, world.annulus, e.norm(), lagged.length);
  const Vector2d n = e.norm() > 0 ? Vector2d(e.normalized()) : Vector2d::UnitX();
  lagged.drags = true;
  lagged.dt = dt;
  lagged.drag_from = state.tip;
  lagged.drag_coefficients.setZero();
  lagged.drag_coefficients(0, 0) = c.axial;
  lagged.drag_coefficients.block<2, 2>(1, 1) =
      c.tangential * Matrix2d::Identity() + (c.radial - c.tangential) * n * n.transpose();
  lagged.drag_arm = {middle - spread, middle + spread};
}

void lag_inertia(const World& world, const State& state, double dt, Lagged& lagged) noexcept {
  if (world.dynamics != Dynamics::inertial || dt == 0) return;
  lagged.inertial = true;
  lagged.second_order = world.integrator == Integrator::bdf2 && state.dt_before > 0 &&
                        std::abs(state.dt_before - dt) <= 1e-9 * dt;
  if (lagged.second_order) {
    lagged.inertia = 2.25 / (dt * dt) * world.holder.mass;
    lagged.inertia_at = (4 * state.tip - state.tip_before) / 3 +
                        2 * dt / 9 * (4 * state.velocity - state.velocity_before);
  } else {
    lagged.inertia = 1 / (dt * dt) * world.holder.mass;
    lagged.inertia_at = state.tip + dt * state.velocity;
  }
}

}  // namespace

Lagged lag(const World& world, const State& state, double dt) noexcept {
  Lagged lagged;
  lagged.length = inserted(world, state.tip);
  lagged.contact = contact_side(world, state);
  lagged.bridge = state.bridge;
  lag_drag(world, state, dt, lagged);
  lag_inertia(world, state, dt, lagged);
  for (std::size_t place = 0; place < kContactPlaces; ++place)
    lagged.branch[place] = state.contact[place].branch;
  const bool both = state.contact[kEnd].closed && state.contact[kSide].closed;
  if (both && world.adhesion && world.adhesion->form == Form::printed) lagged.adhesion_share = 0.5;
  if (!world.friction || (!state.contact[kEnd].closed && !state.contact[kSide].closed))
    return lagged;

  const auto depths = contact_depths(world, lagged.contact, state.tip);
  for (std::size_t place = 0; place < kContactPlaces; ++place) {
    const ContactState& contact = state.contact[place];
    if (!contact.closed || depths[place].value == -INFINITY) continue;
    const double a = friction_radius(world, depths[place].value, contact.branch);
    if (!(a > 0)) continue;
    LaggedFriction& friction = lagged.friction[place];
    const Vector3d& n = depths[place].normal;
    friction.acts = true;
    friction.stuck = contact.stuck;
    friction.tangential = Eigen::Matrix3d::Identity() - n * n.transpose();
    friction.arm = place == kSide ? -state.tip[0] : 0.0;
    const double share = both && world.friction->form == Form::printed ? 0.5 : 1.0;
    friction.limit = share * ferrule::friction(*world.friction, a);
    friction.stiffness = stuck_stiffness(*world.friction, a);
  }
  return lagged;
}

Potential potential(const World& world, const Lagged& lagged, const Pose& hand, const Pose& tip,
                    Forces* out) noexcept {
  Potential total;
  if (out) *out = Forces();
  Breakdown* const b = out ? &out->breakdown : nullptr;
  const Pose stretch = tip - hand;
  total.gradient = world.holder.stiffness * stretch;
  total.value = total.value_scale = 0.5 * stretch.dot(total.gradient);
  total.hessian = world.holder.stiffness;
  total.force_scale = total.gradient.head<3>().norm();
  if (b) b->holder = total.gradient;

  const double weight = world.holder.weight.dot(tip);
  total.value -= weight;
  total.value_scale += std::abs(weight);
  total.gradient -= world.holder.weight;
  total.force_scale += std::abs(world.holder.weight[1]);
  if (b) b->gravity = {{0, world.holder.weight[1], 0}, tip.head<3>() + world.holder.weight_arm};

  if (lagged.inertial) {
    const Pose move = tip - lagged.inertia_at;
    const Pose force = lagged.inertia * move;
    total.value += 0.5 * move.dot(force);
    total.value_scale += 0.5 * move.dot(force);
    total.gradient += force;
    total.hessian += lagged.inertia;
    total.force_scale += force.head<3>().norm();
  }
  if (lagged.length > 0 && has_surface_law(world, Form::printed))
    add_surface(total, world, lagged, Form::printed, tip, b);
  if (tip[0] < 0 && has_surface_law(world, Form::corrected))
    add_surface(total, world, lagged, Form::corrected, tip, b);
  if (out && world.capillary)
    out->bridge =
        tip[0] < 0 && smallest_gap(world, tip) < capillary_reach(*world.capillary, lagged.bridge);
  if (world.meniscus && tip[0] < 0) {
    const double pull = meniscus(*world.meniscus, world.annulus.fibre_radius);
    total.value += pull * tip[0];
    total.value_scale -= pull * tip[0];
    total.gradient[0] += pull;
    total.force_scale += pull;
    if (b) b->meniscus = {{-pull, 0, 0}, tip.head<3>()};
  }
  if (lagged.drags)
    for (std::size_t i = 0; i < 2; ++i) {
      const double arm = lagged.drag_arm[i];
      const Vector3d moved = drag_move(lagged, tip, arm);
      const Eigen::Matrix3d rate = 0.5 / lagged.dt * lagged.drag_coefficients;
      const Vector3d force = rate * moved;
      total.value += 0.5 * moved.dot(force);
      total.value_scale += 0.5 * moved.dot(force);
      add_point(total, world, lagged, arm, force, rate, true);
      if (!b) continue;
      const Vector2d e = eccentricity(tip, arm);
      b->drag[i] = {-force, {tip[0] + arm, e.x(), e.y()}};
    }

  const auto depths = contact_depths(world, lagged.contact, tip);
  for (int place = 0; place < kContactPlaces; ++place) {
    const auto at = static_cast<std::size_t>(place);
    const ContactDepth& depth = depths[at];
    const LaggedFriction& friction = lagged.friction[at];
    if (friction.acts) add_friction(total, world, lagged, friction, tip);
    if (depth.value == -INFINITY) continue;
    const ContactForce push = wall_force(world, depth.value);
    const AdhesionForce pull = shared_adhesion(world, lagged, place, depth.value);
    const double force = push.force + pull.force;
    const double slope = push.slope + pull.slope;
    total.value += push.potential + pull.potential;
    total.value_scale += push.potential + std::abs(pull.potential);
    if (force != 0 || slope != 0) {
      total.gradient += force * depth.gradient;
      total.hessian += slope * depth.gradient * depth.gradient.transpose() + force * depth.hessian;
      total.force_scale += push.force + std::abs(pull.force);
    }
    if (!out) continue;
    b->wall[at] = {push.force * depth.normal, depth.point};
    b->adhesion[at] = {pull.force * depth.normal, depth.point};
    ContactState& contact = out->contact[at];
    contact.closed = depth.value > 0 || pull.radius > 0;
    contact.depth = contact.closed ? depth.value : 0.0;
    contact.branch = pull.branch;
    const double arm = place == kSide ? std::max(0.0, -tip[0]) : 0.0;
    out->material[at] = material_point(world, lagged, tip, arm);
    if (!friction.acts) continue;
    b->friction[at] = {friction_force(friction, material_point(world, lagged, tip, friction.arm)),
                       {tip[0] + friction.arm, depth.point.y(), depth.point.z()}};
  }
  return total;
}

}  // namespace ferrule
