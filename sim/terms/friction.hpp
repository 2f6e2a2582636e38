// Friction: Huber's potential of the elastic slip of each contact. Below its limit the contact
// sticks, and its material point is held elastically where it stuck; at the limit it slides with a
// constant force (sim/laws/friction.hpp).
#pragma once

#include "sim/terms/potential.hpp"

namespace ferrule {

// What the friction that acts has at the contacts of `potential`, with its patches and
// shares; nothing where they do not touch.
std::array<FrictionLimit, kContactPlaces> friction_limits(const World& world,
                                                          const FrozenCoefficients& frozen,
                                                          const Potential& potential) noexcept;

// Tangential stiffness of a sticking contact at `tip`, with the potential there [N/m].
double sticking_stiffness(const World& world, const FrozenCoefficients& frozen,
                          const PoseVector& tip, const Potential& potential, int place) noexcept;

// The fibre's material point that the friction of a place acts on, where it touches now [m].
Vector3d material_point(const World& world, const ContactSide& side, int place,
                        const PoseVector& tip) noexcept;

// Elastic slip of the contact of a place, along its contact plane, at `tip` [m], and by a move of
// the tip.
Vector3d elastic_slip(const World& world, const FrozenCoefficients& frozen, int place,
                      const PoseVector& tip) noexcept;
Vector3d elastic_slip_by(const World& world, const FrozenCoefficients& frozen, int place,
                         const PoseVector& move) noexcept;

// Gradient of the friction of a place that slides, by the pose, for a limit of 1 N.
PoseVector friction_direction(const World& world, const FrozenCoefficients& frozen, int place,
                              const Vector3d& slip) noexcept;

// Adds gradient and Hessian of the friction of a place with the elastic `slip`, as its potential is
// to second order about the slip `about`.
void add_friction_about(Energy& total, const World& world, const FrozenCoefficients& frozen,
                        int place, const Vector3d& slip, const Vector3d& about) noexcept;

// The limit of a contact of that radius.
FrictionLimit friction_limit(const World& world, const FrozenFriction& friction,
                             const ContactRadius& radius) noexcept;

// At given limits.
struct FrictionTerm {
  static void add(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                  Energy& total) noexcept;
  static void report(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                     const Potential& potential, Breakdown& b) noexcept;
};

}  // namespace ferrule
