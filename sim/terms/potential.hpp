// The incremental potential of one step in time: holder + surface forces + contact + friction, and
// where modelled drag and inertia, as a function of the pose the step ends at, with gradient and
// Hessian. Minimising it is the implicit step; its gradient is minus the sum of all forces.
//
// What a step freezes at its start (FrozenCoefficients): the side the fibre's end rests against,
// whether there is a liquid bridge, the branches of the adhesion, the friction limits and the
// normals friction is perpendicular to, the drag coefficients. Corrected surface forces act along
// the inserted length as it changes, and so pull the fibre in by what a longer overlap gains;
// printed ones know no axial force, and take the length of the step's start.
//
// The side's contact is a patch some kPatch wide, which the fibre's end cuts where it is near the
// mouth: its energy and friction fade with the length l of the side that is past it
// (ContactSide::past_mouth), by p^3 (10 - 15 p + 6 p^2), p = l/kPatch. So a fibre slides off the
// rim, and what adhesion gave is paid back meanwhile.
//
// The paper knows one contact between fibre and bore; where end and side touch at once (the fibre
// lies along the wall) its printed adhesion and friction are shared between them in equal parts.
#pragma once

#include "sim/geometry/contact_depth.hpp"
#include "sim/geometry/energy.hpp"
#include "sim/model/breakdown.hpp"
#include "sim/model/world.hpp"
#include "sim/terms/surface_forces.hpp"

namespace ferrule {

inline constexpr double kPatch = 0.5e-6;  // diameter of a contact 1 nm deep [m]

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

// The contacts at a pose (sticking points not moved) and the bridge there.
struct Contacts {
  std::array<ContactState, kContactPlaces> contact;
  bool bridge = false;
};

// The energy of a step that ends at `tip`, up to a constant, with the parts of it that forces()
// needs.
struct Potential : Energy {
  Potential(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip) noexcept;

  // Contacts and gradient of the bore's part after a short move from `tip`, to first order.
  void follow(const PoseVector& move, const PoseVector& tip) noexcept;

  Energy bore;  // surface forces, contacts and meniscus: what does not depend on the step itself
  SurfaceGradients surface = {PoseVector(), PoseVector(), PoseVector()};
  std::array<ContactDepth, kContactPlaces> depth;
  std::array<ContactForce, kContactPlaces> push;   // of the wall
  std::array<AdhesionForce, kContactPlaces> pull;  // of the adhesion
  // Of wall and adhesion along x, at the rim of the end, where it cuts the side's patch [N].
  double push_out = 0, pull_out = 0;
};

// What the friction that acts has at the contacts of the potential `there`, with its patches and
// shares; nothing where they do not touch.
std::array<FrictionLimit, kContactPlaces> friction_limits(const World& world,
                                                          const FrozenCoefficients& frozen,
                                                          const Potential& there) noexcept;

// Tangential stiffness of a sticking contact at `tip`, with the potential there [N/m].
double sticking_stiffness(const World& world, const FrozenCoefficients& frozen,
                          const PoseVector& tip, const Potential& there, int place) noexcept;

// Gradient and Hessian of all but friction at `tip`, from those of the bore's part there.
Energy without_friction(const FrozenCoefficients& frozen, const PoseVector& tip,
                        const PoseVector& bore_gradient, const PoseMatrix& bore_hessian) noexcept;

// From the end to where the printed laws act, in the middle of their length; 0 without any [m]. And
// the gap there; infinite without any [m].
double printed_arm(const World& world, const FrozenCoefficients& frozen) noexcept;
double printed_gap(const World& world, const FrozenCoefficients& frozen,
                   const PoseVector& tip) noexcept;

// What is stiff: energies of one length each, the depths of both contacts (walls and adhesion), the
// printed laws' gap, less the clearance, and the depth in a particle.
struct NonsmoothTerm {
  double share = 1;   // of the patch that acts
  bool acts = false;  // the rest is only set where it does
  double length;      // [m]
  PoseVector slope;   // of it, by the pose
  double energy;      // [J]
  double force;       // derivative of the energy by it [N]
  double stiffness;   // second derivative [N/m]
};
// After the contacts:
inline constexpr std::size_t kPrintedWell = kContactPlaces, kInParticle = kPrintedWell + 1;
inline constexpr std::size_t kNonsmoothTerms = kInParticle + 1;
// The share of the side's patch that the end leaves is held.
std::array<NonsmoothTerm, kNonsmoothTerms> nonsmooth_terms(const World& world,
                                                           const FrozenCoefficients& frozen,
                                                           const PoseVector& tip,
                                                           double side_share) noexcept;
double side_share(const World& world, const FrozenCoefficients& frozen,
                  const PoseVector& tip) noexcept;

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

// The same forces term by term, into a breakdown of nothing; `there` is the potential at `tip`.
void forces(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
            const Potential& there, Breakdown& nothing_yet) noexcept;

Contacts contacts(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                  const Potential& there) noexcept;

// Does a contact or the bridge begin, end or change its branch?
bool contact_set_changed(const State& before, const Contacts& now) noexcept;

}  // namespace ferrule
