// The forces on the fibre, term by term, each with its point of action; the sum is a method.
#pragma once

#include <array>

#include "sim/geometry/pose.hpp"
#include "sim/laws/laws.hpp"

namespace ferrule {

struct World;

struct PointForce {
  Vector3d force = {0, 0, 0};  // on the fibre [N]
  Vector3d point = {0, 0, 0};  // where it acts [m]

  // As a wrench on the rod at `tip` (sim/geometry/pose.hpp).
  Wrench wrench(const Pose& tip) const noexcept {
    const Vector3d arm = point - tip.head<3>();
    Wrench w;
    w << force, arm.x() * force.y() - arm.y() * force.x(),
        arm.x() * force.z() - arm.z() * force.x();
    return w;
  }
};

// Two points per term: the ends of the inserted length for surface forces, which together carry the
// moment; the places of contact (ContactPlace) for adhesion, wall and friction; two arms that
// together carry its moment for drag; the first alone for gravity, meniscus, flow and particle.
using TermForces = std::array<PointForce, 2>;

struct Breakdown {
  std::array<TermForces, kTerms> terms;
  Wrench holder = Wrench::Zero();  // felt at the holder: force and moment of the fibre on it

  const TermForces& operator[](Term term) const noexcept {
    return terms[static_cast<std::size_t>(term)];
  }
  TermForces& operator[](Term term) noexcept { return terms[static_cast<std::size_t>(term)]; }

  // Force of one term, its two points added up [N].
  Vector3d force(Term term) const noexcept {
    return (*this)[term][0].force + (*this)[term][1].force;
  }
  // Everything that acts on the fibre but the holder, as a wrench at `tip`. In equilibrium it
  // equals `holder`.
  Wrench sum(const Pose& tip) const noexcept;
};

// Force of a wrench at the holder without the fibre's weight [N].
Vector3d holder_force(const World& world, const Wrench& holder) noexcept;

}  // namespace ferrule
