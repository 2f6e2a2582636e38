#include "sim/terms/friction.hpp"

#include <cmath>

#include "sim/terms/contact.hpp"

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

// Huber's potential of the elastic slip: elastic while the contact sticks, constant force beyond.
struct Huber {
  double energy;   // [J]
  Vector3d slope;  // minus the force [N]
  Matrix3d curve;  // [N/m]

  Huber(const FrozenFriction& friction, const Vector3d& slip) noexcept {
    const double length = slip.norm();
    energy = 0.5 * friction.stiffness * length * length;
    slope = friction.stiffness * slip;
    curve = friction.stiffness * friction.tangential;
    if (!friction.slides(slip)) return;
    const Vector3d direction = slip / length;
    energy = friction.limit * (length - 0.5 * friction.limit / friction.stiffness);
    slope = friction.limit * direction;
    curve = friction.limit / length * (friction.tangential - direction * direction.transpose());
  }
};

}  // namespace

FrictionLimit friction_limit(const World& world, const FrozenFriction& friction,
                             const ContactRadius& radius) noexcept {
  const double a = radius.value;
  if (!(a > 0)) return {};
  const Friction& law = *friction_law(world.laws);
  const double limit = friction.share * ferrule::friction(law, a);
  return {limit, friction.patch * sticking_stiffness(law, a),
          friction_exponent(law, a) * limit / a * radius.per_depth};
}

std::array<FrictionLimit, kContactPlaces> friction_limits(const World& world,
                                                          const FrozenCoefficients& frozen,
                                                          const Potential& potential) noexcept {
  std::array<FrictionLimit, kContactPlaces> limits;
  for (std::size_t at = 0; at < kContactPlaces; ++at) {
    const double depth = potential.depth[at].value;
    if (frozen.friction[at].acts && depth != -INFINITY)
      limits[at] = friction_limit(world, frozen.friction[at],
                                  friction_radius(world, depth, potential.pull[at]));
  }
  return limits;
}

double sticking_stiffness(const World& world, const FrozenCoefficients& frozen,
                          const PoseVector& tip, const Potential& potential, int place) noexcept {
  const auto at = static_cast<std::size_t>(place);
  const double depth = potential.depth[at].value;
  const double a =
      depth == -INFINITY ? 0.0 : friction_radius(world, depth, potential.pull[at]).value;
  if (!(a > 0)) return 0;
  const double patch = place == kSide ? side_share(world, frozen, tip) : 1.0;
  return patch * sticking_stiffness(*friction_law(world.laws), a);
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
  const Huber huber(friction, about);
  total.add_point(friction.arm, offset(world, frozen, place),
                  huber.slope + huber.curve * (slip - about), huber.curve);
}

void FrictionTerm::add(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                       Energy& total) noexcept {
  for (int place = 0; place < kContactPlaces; ++place) {
    const FrozenFriction& friction = frozen.friction[static_cast<std::size_t>(place)];
    if (!friction.acts) continue;
    const Huber huber(friction, elastic_slip(world, frozen, place, tip));
    total.value += huber.energy;
    total.value_scale += huber.energy;
    total.force_scale += huber.slope.norm();
    total.add_point(friction.arm, offset(world, frozen, place), huber.slope, huber.curve);
  }
}

void FrictionTerm::report(const World& world, const FrozenCoefficients& frozen,
                          const PoseVector& tip, const Potential& potential,
                          Breakdown& b) noexcept {
  for (int place = 0; place < kContactPlaces; ++place) {
    const auto at = static_cast<std::size_t>(place);
    const FrozenFriction& friction = frozen.friction[at];
    if (!friction.acts || potential.depth[at].value == -INFINITY) continue;
    const Vector2d surface = eccentricity(tip, friction.arm) - offset(world, frozen, place);
    b[Term::friction][at] = {-Huber(friction, elastic_slip(world, frozen, place, tip)).slope,
                             {tip.x + friction.arm, surface.x(), surface.y()}};
  }
}

}  // namespace ferrule
