// What holds the fibre: a linear spring in all five coordinates between the commanded pose and the
// fibre's end, with the weight and the inertia that belong to it.
//
// The wrench of the fibre on the holder is stiffness (tip - command), and where the fibre's inertia
// is modelled damping d(tip - command)/dt besides.
#pragma once

#include "sim/laws/laws.hpp"
#include "sim/model/state.hpp"

namespace ferrule {

struct Holder {
  Matrix5 stiffness = Matrix5::Zero();     // [N/m, N/rad, N m/rad], positive definite
  Wrench weight = Wrench::Zero();          // load of gravity on the end's coordinates [N, N m]
  Vector3d weight_arm = Vector3d::Zero();  // from the end to where it acts as one force [m]
  Matrix5 mass = Matrix5::Zero();          // [kg, kg m, kg m^2]
  Matrix5 damping = Matrix5::Zero();       // [N s/m, N s/rad, N m s/rad]
  Pose sag = Pose::Zero();                 // tip - command in free air
  double tilt_length = 1;  // of a lever that makes tilts comparable to positions [m]
  double euler_load = 0;   // buckling load, clamped at the holder and free at the end [N]

  // An elastic fibre's free length and section; 0 for a rigid hand.
  double free_length = 0;   // L [m]
  double fibre_radius = 0;  // [m]

  // Largest bending stress [Pa] in the free length when its end is at `tip`, E r |curvature|: at
  // the holder or at the end. 0 for a rigid hand, which does not bend.
  double bending_stress(const Pose& tip, const Pose& command) const noexcept;

  // omega_1, of the first mode of what bends [rad/s].
  double bending_frequency() const noexcept;

  // Work [J] of a hand that moves from one command to the next while the end holds still at `tip`.
  double work_of_hand(const Pose& tip, const Pose& from, const Pose& to) const noexcept;

  // How far a newton may move the end [m/N].
  double compliance() const noexcept;
};

// The rigid hand of the paper: a virtual coupling of given stiffness [N/m] and [N m/rad] to the end
// of a rigid fibre. It carries the weight at its own grip: the weight pulls, but does not tilt.
Holder rigid_hand(double stiffness, double tilt_stiffness, const FibreMass& fibre, double young,
                  const GravityLaw& gravity);

// An elastic fibre of free length L, clamped in a gripper: Euler-Bernoulli,
//   lateral deflection and slope of the end: E I/L^3 [[12, 6 L], [6 L, 4 L^2]]
//   (the slope counted along x, towards the gripper), axial: E A/L in series with the gripper.
// Weight and mass are the consistent loads of a uniform cantilever: the end sags by
// rho A g L^4/(8 E I). `gripper_stiffness` [N/m], > 0.
//
// What its bending dissipates is that of a Kelvin-Voigt solid, for the loss factor eta >= 0 of its
// first mode: damping = eta/omega_1 times the stiffness in bending, so that mode rings as
//   exp(-eta omega_1 t/2) cos(sqrt(1 - eta^2/4) omega_1 t + phase),
// falling by pi eta a period (logarithmic decrement, Q = 1/eta), and the second, whose loss is eta
// omega_2/omega_1, 10 times as much, dies away sooner. Of a solid whose loss factor is the same at
// any frequency (structural damping) this is what it is at omega_1, at which a fibre rings.
Holder elastic_fibre(double free_length, double gripper_stiffness, const FibreMass& fibre,
                     double young, const GravityLaw& gravity, double loss_factor = 0);

}  // namespace ferrule
