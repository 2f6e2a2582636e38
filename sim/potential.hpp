// The incremental potential of one step in time: holder + surface forces + contact + friction, as a
// function of the pose the step ends at, with gradient and Hessian. Minimising it is the implicit
// (backward Euler) step of the quasi-static equations; its gradient is minus the sum of all forces.
//
// What a step holds fixed at its start (Lagged): the inserted length, the side the fibre's end
// rests against, the friction limits and the normals friction is perpendicular to. The paper knows
// one contact between fibre and bore; where end and side touch at once (the fibre lies along the
// wall) they share its adhesion and its friction in equal parts.
#pragma once

#include "sim/breakdown.hpp"
#include "sim/world.hpp"

namespace ferrule {

struct LaggedFriction {
  bool acts = false;
  Vector3d stuck;              // [m]
  Eigen::Matrix3d tangential;  // projector onto the contact plane
  double arm = 0;              // s of the contact's material point [m]
  double limit = 0;            // largest force [N]
  double stiffness = 0;        // k_t [N/m]
};

struct Lagged {
  double length = 0;  // l_f [m]
  EdgeSide side = EdgeSide::throat;
  Vector2d outward = Vector2d::Zero();  // unit direction from the bore's axis to the fibre's end
  bool side_can_touch = false;          // the end is in the bore, so the mouth's rim faces the side
  double adhesion_share = 1;            // of each contact place in the one contact of law (6)
  std::array<LaggedFriction, kContactPlaces> friction;
};

Lagged lag(const World& world, const State& state) noexcept;

struct Potential {
  double value = 0;              // [J]
  Pose gradient = Pose::Zero();  // [N, N m]
  Eigen::Matrix<double, 5, 5> hessian = Eigen::Matrix<double, 5, 5>::Zero();
  // Sums of the magnitudes of all energies and forces in it [J], [N]: what rounding is relative to.
  double value_scale = 0, force_scale = 0;
};

Potential potential(const World& world, const Lagged& lagged, const Pose& hand,
                    const Pose& tip) noexcept;

// The same forces, term by term, at `tip`, and the contacts there (stuck points not moved).
struct Forces {
  Breakdown breakdown;
  std::array<ContactState, kContactPlaces> contact;
  std::array<Vector3d, kContactPlaces> material;  // material point that friction acts on [m]
};
Forces forces(const World& world, const Lagged& lagged, const Pose& hand, const Pose& tip) noexcept;

}  // namespace ferrule
