// The incremental potential of one step in time: holder + surface forces + contact + friction, and
// where modelled drag and inertia, as a function of the pose the step ends at, with gradient and
// Hessian. Minimising it is the implicit step; its gradient is minus the sum of all forces.
//
// Each term has a file of its own in this folder. It adds its energy, gradient and Hessian, and
// reports its force with its point of action; sim/terms/potential.cpp has the list of them.
// Corrected surface forces act along the inserted length as it changes, and so pull the fibre in by
// what a longer overlap gains; printed ones know no axial force, and take the length of the step's
// start.
#pragma once

#include "sim/model/breakdown.hpp"
#include "sim/terms/frozen_coefficients.hpp"
#include "sim/terms/surface_forces.hpp"

namespace ferrule {

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

// Gradient and Hessian of all but friction at `tip`, from those of the bore's part there.
Energy without_friction(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                        const PoseVector& bore_gradient, const PoseMatrix& bore_hessian) noexcept;

// The forces of all terms, into a breakdown of nothing; `there` is the potential at `tip`.
void forces(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
            const Potential& there, Breakdown& nothing_yet) noexcept;

}  // namespace ferrule
