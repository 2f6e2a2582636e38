// The terms that are stiff or have kinks, as energies of one length each: the depths of both
// contacts (wall and adhesion), the printed laws' gap, less the clearance, and the depth in a
// particle. They cost little to compute, and are what the line search looks at
// (sim/solver/line_search.hpp).
#pragma once

#include "sim/terms/potential.hpp"

namespace ferrule {

struct NonsmoothTerm {
  double share = 1;   // of the patch that acts
  bool acts = false;  // the rest is only set where it does
  double length;      // [m]
  PoseVector slope;   // of it, by the pose
  double energy;      // [J]
  double force;       // derivative of the energy by it [N]
  double stiffness;   // second derivative [N/m]
  // Second derivative of the length by the eccentricity at `arm` from the end [1/m, m], where the
  // force is so large that what it bends by matters; else 0.
  Matrix2d curvature = Matrix2d::Zero();
  double arm = 0;
};
// After the contacts:
inline constexpr std::size_t kPrintedWell = kContactPlaces, kInParticle = kPrintedWell + 1;
inline constexpr std::size_t kNonsmoothTerms = kInParticle + 1;
// The share of the side's patch that the end leaves is held.
std::array<NonsmoothTerm, kNonsmoothTerms> nonsmooth_terms(const World& world,
                                                           const FrozenCoefficients& frozen,
                                                           const PoseVector& tip,
                                                           double side_share) noexcept;

}  // namespace ferrule
