// The forces on the fibre, term by term, each with its point of action; the sum is a method.
#pragma once

#include <array>

#include "sim/state.hpp"
#include "sim/world.hpp"

namespace ferrule {

struct PointForce {
  Vector3d force = {0, 0, 0};  // on the fibre [N]
  Vector3d point = {0, 0, 0};  // where it acts [m]

  // As a wrench on the rod at `tip` (sim/state.hpp).
  Wrench wrench(const Pose& tip) const noexcept {
    const Vector3d arm = point - tip.head<3>();
    Wrench w;
    w << force, arm.x() * force.y() - arm.y() * force.x(),
        arm.x() * force.z() - arm.z() * force.x();
    return w;
  }
};

struct Breakdown {
  // Along the inserted length, as the two forces at its ends that together carry the moment.
  std::array<PointForce, 2> van_der_waals, electrostatic, capillary;
  PointForce gravity, meniscus;
  std::array<PointForce, kContactPlaces> adhesion, wall, friction;
  std::array<PointForce, 2> drag;  // at two arms that together carry its moment
  Wrench holder = Wrench::Zero();  // felt at the holder: force and moment of the fibre on the hand

  // Everything that acts on the fibre but the holder, as a wrench at `tip`. In equilibrium it
  // equals `holder`.
  Wrench sum(const Pose& tip) const noexcept;
  // Adhesion and friction together, equation (11) of the paper [N].
  Vector3d contact() const noexcept;
};

// The terms in the order of their columns in files and tables.
inline constexpr int kTerms = 9;
inline constexpr std::array<const char*, kTerms> kTermNames = {
    "van_der_waals", "electrostatic", "gravity", "capillary", "adhesion",
    "wall",          "friction",      "drag",    "meniscus"};
// Force of each term, contact places added up [N], in that order.
std::array<Vector3d, kTerms> term_forces(const Breakdown& breakdown) noexcept;

// Force at the holder without the fibre's weight [N].
Vector3d holder_force(const World& world, const Breakdown& breakdown) noexcept;

}  // namespace ferrule
