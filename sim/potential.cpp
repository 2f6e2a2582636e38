#include "sim/potential.hpp"

namespace ferrule {
namespace {

using Matrix5 = Eigen::Matrix<double, 5, 5>;
using Eigen::Matrix2d;

// The direction of the surface forces is undefined on the bore's axis; it fades out within this
// fraction of the clearance: e -> sqrt(e^2 + (fraction c)^2).
constexpr double kSmoothing = 1e-3;

// Eccentricity and its derivatives with respect to the vector `e`.
struct Radial {
  double eccentricity;
  Vector2d normal;   // d eccentricity / de, of length <= 1
  Matrix2d curving;  // d normal / de

  Radial(const Vector2d& e, double clearance) noexcept {
    const double smooth = kSmoothing * clearance;
    eccentricity = std::sqrt(e.squaredNorm() + smooth * smooth);
    normal = e / eccentricity;
    curving = (Matrix2d::Identity() - normal * normal.transpose()) / eccentricity;
  }
};

// The depth d of one contact as a function of the pose: value, gradient, Hessian.
struct Depth {
  double value = -INFINITY;
  Pose gradient = Pose::Zero();
  Matrix5 hessian = Matrix5::Zero();
  Vector3d normal = Vector3d::Zero();  // from the ferrule into the fibre, unit
  // Where the contact acts, to first order in the tilts: so that the wrench of `normal` there is
  // minus the gradient.
  Vector3d point = Vector3d::Zero();
};

void add_radial(Depth& depth, const Radial& radial, double weight, double arm, const Pose& tip,
                double arm_per_x) noexcept {
  const Vector2d n = weight * radial.normal;
  const Matrix2d k = weight * radial.curving;
  const Vector2d by_x = arm_per_x * tip.tail<2>();
  depth.gradient[0] += n.dot(by_x);
  depth.gradient.segment<2>(1) += n;
  depth.gradient.tail<2>() += arm * n;
  depth.hessian.block<2, 2>(1, 1) += k;
  depth.hessian.block<2, 2>(1, 3) += arm * k;
  depth.hessian.block<2, 2>(3, 1) += arm * k;
  depth.hessian.block<2, 2>(3, 3) += arm * arm * k;
  if (arm_per_x == 0) return;
  const Vector2d kx = k * by_x;
  depth.hessian(0, 0) += by_x.dot(kx);
  depth.hessian.block<1, 2>(0, 1) += kx.transpose();
  depth.hessian.block<2, 1>(1, 0) += kx;
  depth.hessian.block<1, 2>(0, 3) += (arm * kx + arm_per_x * n).transpose();
  depth.hessian.block<2, 1>(3, 0) += arm * kx + arm_per_x * n;
}

Vector3d outward3(const Vector2d& n) noexcept {
  return {0, n.x(), n.y()};
}

// The rim of the fibre's end: on the bore wall, the cone or the face.
Depth end_depth(const World& world, const Lagged& lagged, const Pose& tip) noexcept {
  const double r = world.annulus.fibre_radius;
  const Radial radial(tip.segment<2>(1), world.annulus.clearance());
  const double x_rim = tip[0] - r * lagged.outward.dot(tip.tail<2>());
  const EdgeDepth d = edge_depth(world.profile, x_rim, radial.eccentricity + r);

  Depth depth;
  depth.point << tip[0], tip.segment<2>(1) + r * radial.normal;
  if (lagged.side == EdgeSide::face) {
    if (d.throat() <= 0) return depth;
    depth.value = d.face;
    depth.normal = Vector3d::UnitX();
    depth.gradient << -1, 0, 0, r * lagged.outward;
    return depth;
  }
  if (d.face <= 0) return depth;
  depth.value = d.throat();
  const bool on_cone = d.cone < d.bore;
  const double tangent = on_cone ? world.profile.lead_in_tangent : 0;
  const double cosine = 1 / std::sqrt(1 + tangent * tangent);
  const double sine = tangent * cosine;
  depth.normal = sine * Vector3d::UnitX() - cosine * outward3(radial.normal);
  depth.gradient << -sine, 0, 0, sine * r * lagged.outward;
  add_radial(depth, radial, cosine, 0, tip, 0);
  return depth;
}

// The rim of the bore's mouth on the fibre's side.
Depth side_depth(const World& world, const Lagged& lagged, const Pose& tip) noexcept {
  Depth depth;
  if (!lagged.side_can_touch || tip[0] >= 0) return depth;
  const double arm = -tip[0];
  const Vector2d e = eccentricity(tip, arm);
  const Radial radial(e, world.annulus.clearance());
  depth.value = radial.eccentricity - world.annulus.clearance();
  depth.normal << radial.normal.dot(tip.tail<2>()), -radial.normal;
  depth.point = outward3(e);
  add_radial(depth, radial, 1, arm, tip, -1);
  return depth;
}

std::array<Depth, kContactPlaces> contact_depths(const World& world, const Lagged& lagged,
                                                 const Pose& tip) noexcept {
  return {end_depth(world, lagged, tip), side_depth(world, lagged, tip)};
}

// Surface forces act at the middle of the inserted length, on the gap there.
struct SurfaceLaws {
  LineForce van_der_waals, electrostatic, capillary;
};

SurfaceLaws surface_laws(const World& world, double h) noexcept {
  SurfaceLaws laws;
  if (world.van_der_waals)
    laws.van_der_waals = van_der_waals(*world.van_der_waals, world.annulus, h);
  if (world.electrostatic)
    laws.electrostatic = electrostatic(*world.electrostatic, world.annulus, h);
  if (world.capillary) laws.capillary = capillary(*world.capillary, h);
  return laws;
}

bool has_surface_laws(const World& world) noexcept {
  return world.van_der_waals || world.electrostatic || world.capillary;
}

// Material point of a contact: on the fibre's surface along x, on its axis across.
Vector3d material_point(const World& world, const Lagged& lagged, const Pose& tip,
                        double arm) noexcept {
  const double r = world.annulus.fibre_radius;
  Vector3d p;
  p << tip[0] - r * lagged.outward.dot(tip.tail<2>()), eccentricity(tip, arm);
  return p;
}

// Huber's potential of the tangential displacement: elastic while stuck, constant force beyond.
Vector3d friction_force(const LaggedFriction& friction, const Vector3d& material) noexcept {
  const Vector3d stretch = friction.tangential * (material - friction.stuck);
  const double elastic = friction.stiffness * stretch.norm();
  return elastic <= friction.limit ? Vector3d(-friction.stiffness * stretch)
                                   : Vector3d(-friction.limit * stretch.normalized());
}

void add_friction(Potential& total, const World& world, const Lagged& lagged,
                  const LaggedFriction& friction, const Pose& tip) noexcept {
  const Vector3d stretch =
      friction.tangential * (material_point(world, lagged, tip, friction.arm) - friction.stuck);
  const double length = stretch.norm();
  Vector3d gradient;
  Eigen::Matrix3d hessian;
  if (friction.stiffness * length <= friction.limit) {
    total.value += 0.5 * friction.stiffness * length * length;
    gradient = friction.stiffness * stretch;
    hessian = friction.stiffness * friction.tangential;
  } else {
    const Vector3d direction = stretch / length;
    total.value += friction.limit * (length - 0.5 * friction.limit / friction.stiffness);
    gradient = friction.limit * direction;
    hessian = friction.limit / length * (friction.tangential - direction * direction.transpose());
  }
  Eigen::Matrix<double, 3, 5> jacobian = Eigen::Matrix<double, 3, 5>::Zero();
  jacobian.leftCols<3>().setIdentity();
  jacobian.block<1, 2>(0, 3) = -world.annulus.fibre_radius * lagged.outward.transpose();
  jacobian(1, 3) = jacobian(2, 4) = friction.arm;
  total.gradient += jacobian.transpose() * gradient;
  total.hessian += jacobian.transpose() * hessian * jacobian;
  total.force_scale += gradient.norm();
}

ContactForce shared_adhesion(const World& world, const Lagged& lagged, double depth) noexcept {
  if (!world.adhesion) return {};
  const ContactForce whole = adhesion(*world.adhesion, depth);
  const double share = lagged.adhesion_share;
  return {share * whole.potential, share * whole.force, share * whole.slope};
}

}  // namespace

Lagged lag(const World& world, const State& state) noexcept {
  Lagged lagged;
  lagged.length = std::min(state.inserted_length(), world.profile.length);
  const Vector2d e = state.tip.segment<2>(1);
  lagged.outward = e.norm() > 0 ? Vector2d(e.normalized()) : Vector2d::UnitX();
  const double r = world.annulus.fibre_radius;
  const double x_rim = state.tip[0] - r * lagged.outward.dot(state.tip.tail<2>());
  const EdgeDepth d = edge_depth(world.profile, x_rim, e.norm() + r);
  lagged.side = edge_side(d, state.side);
  lagged.side_can_touch = state.tip[0] < 0 && !(lagged.side == EdgeSide::face && d.inside());
  if (state.contact[kEnd].closed && state.contact[kSide].closed) lagged.adhesion_share = 0.5;
  if (!world.friction) return lagged;

  const auto depths = contact_depths(world, lagged, state.tip);
  for (int place = 0; place < kContactPlaces; ++place) {
    const ContactState& contact = state.contact[place];
    if (!contact.closed || !(depths[place].value > 0)) continue;
    LaggedFriction& friction = lagged.friction[place];
    const Vector3d& n = depths[place].normal;
    const double a = printed_contact_radius(depths[place].value);
    friction.acts = true;
    friction.stuck = contact.stuck;
    friction.tangential = Eigen::Matrix3d::Identity() - n * n.transpose();
    friction.arm = place == kSide ? -state.tip[0] : 0.0;
    friction.limit = lagged.adhesion_share * ferrule::friction(*world.friction, a);
    friction.stiffness = stuck_stiffness(*world.friction, a);
  }
  return lagged;
}

Potential potential(const World& world, const Lagged& lagged, const Pose& hand,
                    const Pose& tip) noexcept {
  Potential total;
  const Pose stretch = tip - hand;
  Pose stiffness;
  stiffness << Vector3d::Constant(world.holder.stiffness),
      Vector2d::Constant(world.holder.tilt_stiffness);
  total.gradient = stiffness.cwiseProduct(stretch);
  total.value = total.value_scale = 0.5 * stretch.dot(total.gradient);
  total.hessian.diagonal() = stiffness;
  total.force_scale = total.gradient.head<3>().norm();

  if (world.gravity) {
    const double weight = gravity(*world.gravity, world.fibre);
    total.value += weight * tip[1];
    total.value_scale += std::abs(weight * tip[1]);
    total.gradient[1] += weight;
    total.force_scale += weight;
  }

  if (lagged.length > 0 && has_surface_laws(world)) {
    const double arm = 0.5 * lagged.length;
    const Radial radial(eccentricity(tip, arm), world.annulus.clearance());
    const SurfaceLaws laws = surface_laws(world, world.annulus.clearance() - radial.eccentricity);
    const double force = laws.van_der_waals.force + laws.electrostatic.force + laws.capillary.force;
    const double slope = laws.van_der_waals.slope + laws.electrostatic.slope + laws.capillary.slope;
    Depth e;  // the eccentricity as a function of the pose
    add_radial(e, radial, 1, arm, tip, 0);
    const double value = lagged.length * (laws.van_der_waals.potential +
                                          laws.electrostatic.potential + laws.capillary.potential);
    total.value += value;
    total.value_scale += std::abs(value);
    total.gradient += lagged.length * force * e.gradient;
    total.hessian +=
        lagged.length * (force * e.hessian - slope * e.gradient * e.gradient.transpose());
    total.force_scale -= lagged.length * force;
  }

  const auto depths = contact_depths(world, lagged, tip);
  for (int place = 0; place < kContactPlaces; ++place) {
    const Depth& depth = depths[place];
    if (depth.value == -INFINITY) continue;
    const ContactForce push = wall(world.wall, depth.value);
    const ContactForce pull = shared_adhesion(world, lagged, depth.value);
    const double force = push.force + pull.force;
    const double slope = push.slope + pull.slope;
    total.value += push.potential + pull.potential;
    total.value_scale += push.potential + std::abs(pull.potential);
    if (force == 0 && slope == 0) continue;
    total.gradient += force * depth.gradient;
    total.hessian += slope * depth.gradient * depth.gradient.transpose() + force * depth.hessian;
    total.force_scale += push.force - pull.force;
  }
  for (const LaggedFriction& friction : lagged.friction)
    if (friction.acts) add_friction(total, world, lagged, friction, tip);
  return total;
}

Forces forces(const World& world, const Lagged& lagged, const Pose& hand,
              const Pose& tip) noexcept {
  Forces out;
  Breakdown& b = out.breakdown;
  b.holder << world.holder.stiffness * (tip - hand).head<3>(),
      world.holder.tilt_stiffness * (tip - hand).tail<2>();
  if (world.gravity) b.gravity = {{0, -gravity(*world.gravity, world.fibre), 0}, tip.head<3>()};

  if (lagged.length > 0 && has_surface_laws(world)) {
    const double arm = 0.5 * lagged.length;
    const Vector2d e = eccentricity(tip, arm);
    const Radial radial(e, world.annulus.clearance());
    const SurfaceLaws laws = surface_laws(world, world.annulus.clearance() - radial.eccentricity);
    const Vector3d towards_wall = outward3(radial.normal);
    const Vector3d point = Vector3d(tip[0] + arm, e.x(), e.y());
    b.van_der_waals = {-lagged.length * laws.van_der_waals.force * towards_wall, point};
    b.electrostatic = {-lagged.length * laws.electrostatic.force * towards_wall, point};
    b.capillary = {-lagged.length * laws.capillary.force * towards_wall, point};
  }

  const auto depths = contact_depths(world, lagged, tip);
  for (int place = 0; place < kContactPlaces; ++place) {
    const Depth& depth = depths[place];
    const double arm = place == kSide ? std::max(0.0, -tip[0]) : 0.0;
    out.material[place] = material_point(world, lagged, tip, arm);
    if (depth.value == -INFINITY) continue;
    b.wall[place] = {wall(world.wall, depth.value).force * depth.normal, depth.point};
    b.adhesion[place] = {shared_adhesion(world, lagged, depth.value).force * depth.normal,
                         depth.point};
    out.contact[place].closed = depth.value > 0;
    out.contact[place].depth = std::max(0.0, depth.value);
    const LaggedFriction& friction = lagged.friction[place];
    if (!friction.acts) continue;
    const Vector3d material = material_point(world, lagged, tip, friction.arm);
    Vector3d point = depth.point;
    point.x() = tip[0] + friction.arm;
    b.friction[place] = {friction_force(friction, material), point};
  }
  return out;
}

}  // namespace ferrule
