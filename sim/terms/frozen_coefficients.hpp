// What a sub-step holds constant, from where it starts: the side the fibre's end rests against,
// whether there is a liquid bridge, the branches of the adhesion, the friction limits and the
// normals friction is perpendicular to, the drag coefficients. And what of holder, inertia and drag
// is quadratic in the pose then.
#pragma once

#include "sim/geometry/contact_depth.hpp"
#include "sim/geometry/energy.hpp"
#include "sim/model/world.hpp"

namespace ferrule {

struct FrictionLimit {
  double limit = 0;      // largest force [N]
  double stiffness = 0;  // k_t [N/m]
  double per_depth = 0;  // d limit / d depth [N/m]
};

struct FrozenFriction : FrictionLimit {
  bool acts = false;       // the rest is only set where it does
  Vector3d stuck;          // where the contact's material point sticks [m]
  Matrix3d tangential;     // projector onto the contact plane
  double arm;              // s of the material point [m]
  double patch;            // share of the contact's patch that is there
  double share;            // of the law's limit
  PoseVector depth_slope;  // of the contact's depth, by the pose

  bool slides(const Vector3d& slip) const noexcept { return stiffness * slip.norm() > limit; }
};

struct FrozenCoefficients {
  PoseVector command;  // at the step's end
  double length = 0;   // l_f [m]
  ContactSide contact;
  bool bridge = false;
  double adhesion_share = 1;
  std::array<int, kContactPlaces> branch{};
  std::array<FrozenFriction, kContactPlaces> friction;

  // Holder, weight, drag sideways and inertia together: with q the move since the step's start
  // `from`, q.stiffness q/2 - load.q.
  PoseVector from;
  PoseMatrix stiffness;  // [N/m, N/rad, N m/rad]
  PoseVector load;       // [N, N m]
  double load_scale;     // sum of the magnitudes of what the load consists of [N]

  // Drag along x is k l per speed at the inserted length l, which changes with the step itself:
  // k (l^2 - l_0^2)/(2 dt), of energy k (l - l_0)^2 (l + 2 l_0)/(6 dt). Sideways it is frozen.
  double axial_drag = 0;  // k/dt [N/m^2]; 0 without drag
  // Force over displacement, sideways, at each of two arms [N/m].
  Matrix2d drag_per_move = Matrix2d::Zero();
  std::array<double, 2> drag_arm{};  // [m]

  FlowStep flow;  // of the fluid ahead of the end

  // Of the holder's damping at the step's end: damping (rate move - drift), over dt; 0 without it.
  double damping_rate = 0;   // [1/s]
  PoseVector damping_drift;  // of the holder, less what the fibre had before [m/s, rad/s]

  bool inertial = false;
  bool second_order = false;  // this step is one of BDF2

  bool has_friction() const noexcept { return friction[kEnd].acts || friction[kSide].acts; }
};

// For a step from `state` to `command` over `dt` [s], which is only looked at where drag
// or inertia is modelled.
FrozenCoefficients freeze(const World& world, const State& state, const Pose& command,
                          double dt) noexcept;

}  // namespace ferrule
