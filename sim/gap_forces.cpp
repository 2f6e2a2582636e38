#include "sim/gap_forces.hpp"

#include <algorithm>
#include <cmath>

#include "sim/laws/printed_range.hpp"

namespace ferrule {
namespace {

// The branch on which the surfaces touch.
int contact_branch(const World& world) {
  return world.adhesion && world.adhesion->contact ? world.adhesion->contact->curve.branches() : 0;
}

// Mean of a corrected law along a fibre whose gap widens in a straight line from `gap` by `rise`;
// beyond the bore's axis the opposite wall is the near one. Gauss-Legendre between the gaps where
// the law ends and between those that are an octave apart.
template <class Law>
double mean_force(const Law& law, double clearance, double reach, double gap, double rise) {
  std::vector<double> cuts = {0, 1};
  const auto cut = [&](double h) {
    for (const double there : {h, 2 * clearance - h})
      if (const double part = (there - gap) / rise; part > 0 && part < 1) cuts.push_back(part);
  };
  for (double h = printed::kInteratomicDistance; h < clearance; h *= 2) cut(h);
  cut(clearance);
  cut(reach);
  std::sort(cuts.begin(), cuts.end());
  static const Quadrature nodes = Quadrature::gauss_legendre(kMostNodes);
  double sum = 0;
  for (std::size_t i = 1; i < cuts.size(); ++i) {
    const double width = cuts[i] - cuts[i - 1];
    for (std::size_t n = 0; n < kMostNodes; ++n) {
      const double h = gap + rise * (cuts[i - 1] + width * nodes.node[n]);
      sum += width * nodes.weight[n] * (h > clearance ? -law(2 * clearance - h) : law(h));
    }
  }
  return sum;
}

}  // namespace

GapForces gap_forces(const World& world, double gap, double length, std::optional<double> depth,
                     const Lie& lie) {
  GapForces forces;
  const Annulus& annulus = world.annulus;
  const double rise = length * lie.tilt;
  const auto along = [&](Form form, double reach, const auto& law) {
    if (length == 0) return 0.0;
    if (form == Form::printed || rise == 0) return length * law(gap + 0.5 * rise);
    return length * mean_force(law, annulus.clearance(), reach, gap, rise);
  };
  if (const auto& law = world.van_der_waals)
    forces.van_der_waals =
        along(law->form, 0, [&](double h) { return van_der_waals(*law, annulus, h).force; });
  if (const auto& law = world.electrostatic)
    forces.electrostatic =
        along(law->form, 0, [&](double h) { return electrostatic(*law, annulus, h).force; });
  if (const auto& law = world.capillary)
    forces.capillary = along(law->form, capillary_reach(*law, true),
                             [&](double h) { return capillary(*law, annulus, h, true).force; });
  if (length > 0 && world.meniscus)
    forces.meniscus = meniscus(*world.meniscus, annulus.fibre_radius);
  if (world.drag) {
    const double eccentricity = std::abs(annulus.clearance() - gap - 0.5 * rise);
    const DragCoefficients k = drag(*world.drag, annulus, eccentricity, length);
    forces.drag = k.axial * lie.speed;
    forces.squeeze = k.radial * lie.speed;
  }
  // Towards the wall below the fibre.
  if (world.gravity) forces.gravity = -gravity(*world.gravity, world.fibre);
  if (depth) {
    const int branch = contact_branch(world);
    if (world.adhesion) forces.adhesion = adhesion(*world.adhesion, *depth, branch).force;
    if (world.wall) forces.wall = wall(*world.wall, *depth).force;
    if (world.friction)
      forces.friction = friction(*world.friction, friction_radius(world, *depth, branch));
  }
  return forces;
}

}  // namespace ferrule
