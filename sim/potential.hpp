// The incremental potential of one step in time: holder + surface forces + contact + friction, and
// where modelled drag and inertia, as a function of the pose the step ends at, with gradient and
// Hessian. Minimising it is the implicit step; its gradient is minus the sum of all forces.
//
// What a step holds fixed at its start (Lagged): the side the fibre's end rests against, whether
// there is a liquid bridge, the branches of the adhesion, the friction limits and the normals
// friction is perpendicular to, the drag coefficients. Corrected surface forces act along the
// inserted length as it changes, and so pull the fibre in by what a longer overlap gains; printed
// ones know no axial force, and take the length of the step's start.
//
// The paper knows one contact between fibre and bore; where end and side touch at once (the fibre
// lies along the wall) its printed adhesion and friction are shared between them in equal parts.
#pragma once

#include "sim/breakdown.hpp"
#include "sim/contact_depth.hpp"
#include "sim/world.hpp"

namespace ferrule {

struct LaggedFriction {
  bool acts = false;
  Vector3d stuck = Vector3d::Zero();                         // [m]
  Eigen::Matrix3d tangential = Eigen::Matrix3d::Identity();  // projector onto the contact plane
  double arm = 0;                                            // s of the material point [m]
  double limit = 0;                                          // largest force [N]
  double stiffness = 0;                                      // k_t [N/m]
};

struct Lagged {
  double length = 0;  // l_f [m]
  ContactSide contact;
  bool bridge = false;
  double adhesion_share = 1;
  std::array<int, kContactPlaces> branch{};
  std::array<LaggedFriction, kContactPlaces> friction;

  bool drags = false;
  Pose drag_from = Pose::Zero();
  Eigen::Matrix<double, 3, 3> drag_coefficients;  // axial, and sideways [N s/m]
  std::array<double, 2> drag_arm{};               // [m]
  double dt = 0;                                  // [s]

  bool inertial = false;
  bool second_order = false;  // this step is one of BDF2
  Matrix5 inertia;            // mass times the square of the integrator's coefficient over dt^2
  Pose inertia_at;            // where the fibre would be without forces
};

// `dt` [s] is only looked at where drag or inertia is modelled.
Lagged lag(const World& world, const State& state, double dt) noexcept;

// The forces at a pose, term by term, and the contacts there (stuck points not moved).
struct Forces {
  Breakdown breakdown;
  std::array<ContactState, kContactPlaces> contact;
  // Material point that friction acts on [m].
  std::array<Vector3d, kContactPlaces> material = {Vector3d::Zero(), Vector3d::Zero()};
  bool bridge = false;
};

struct Potential {
  double value = 0;              // [J]
  Pose gradient = Pose::Zero();  // [N, N m]
  Matrix5 hessian = Matrix5::Zero();
  // Sums of the magnitudes of all energies and forces in it [J], [N]: what rounding is relative to.
  double value_scale = 0, force_scale = 0;
};

// At `tip` with the hand at `hand`; `forces`, where given, gets the same forces term by term.
Potential potential(const World& world, const Lagged& lagged, const Pose& hand, const Pose& tip,
                    Forces* forces = nullptr) noexcept;

}  // namespace ferrule
