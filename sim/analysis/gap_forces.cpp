#include "sim/analysis/gap_forces.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <vector>

#include "sim/base/error.hpp"
#include "sim/scene/terms.hpp"
#include "sim/terms/particle_depth.hpp"

namespace ferrule {
namespace {

template <class... Parts>
[[noreturn]] void refuse_posture(const Parts&... parts) {
  std::ostringstream text;
  (text << ... << parts);
  throw BadInput(text.str());
}

// Of a printed law along the inserted length, at the gap at its middle.
double along(const LineForce& middle, const Posture& at) {
  return at.length == 0 ? 0 : at.length * middle.force;
}

double middle_gap(const Posture& at) {
  return at.gap + 0.5 * at.rise();
}

// Of a corrected law.
template <class Law>
double along(const Law& law, double reach, const World& world, const Posture& at) {
  if (at.length == 0) return 0;
  return at.length * mean_line_force([&](double h) { return law(h).force; }, world, reach, at);
}

double van_der_waals_at_gap(const World& world, const Posture& at) {
  if (const auto* law = std::get_if<printed::VanDerWaals>(&world.laws.van_der_waals))
    return along(printed::van_der_waals(*law, world.annulus, middle_gap(at)), at);
  const auto& law = std::get<VanDerWaals>(world.laws.van_der_waals);
  return along([&](double h) { return van_der_waals(law, world.annulus, h); }, 0, world, at);
}

double electrostatic_at_gap(const World& world, const Posture& at) {
  if (const auto* law = std::get_if<printed::Electrostatic>(&world.laws.electrostatic))
    return along(printed::electrostatic(*law, world.annulus, middle_gap(at)), at);
  const auto& law = std::get<Electrostatic>(world.laws.electrostatic);
  return along([&](double h) { return electrostatic(law, world.annulus, h); }, 0, world, at);
}

// Towards the wall below the fibre: as much as the holder leaves to the end.
double gravity_at_gap(const World& world, const Posture&) {
  return world.holder.weight[1];
}

double capillary_at_gap(const World& world, const Posture& at) {
  if (const auto* law = std::get_if<printed::Capillary>(&world.laws.capillary))
    return along(printed::capillary(*law, middle_gap(at)), at);
  const auto& law = std::get<Capillary>(world.laws.capillary);
  return along([&](double h) { return capillary(law, world.annulus, h, true); },
               capillary_range(law, true), world, at);
}

// The branch on which the surfaces touch.
int contact_branch(const World& world) {
  const auto* law = std::get_if<Adhesion>(&world.laws.adhesion);
  return law ? law->contact->curve.branches() : 0;
}

double adhesion_at_gap(const World& world, const Posture& at) {
  return at.depth ? adhesion_force(world.laws, *at.depth, contact_branch(world)).force : 0;
}

double wall_at_gap(const World& world, const Posture& at) {
  return at.depth ? wall(*world.laws.wall, *at.depth).force : 0;
}

double friction_at_gap(const World& world, const Posture& at) {
  if (!at.depth) return 0;
  return friction(*friction_law(world.laws),
                  friction_radius(world, *at.depth, contact_branch(world)).value);
}

DragCoefficients drag_coefficients(const World& world, const Posture& at) {
  const double eccentricity = std::abs(world.annulus.clearance() - at.gap - 0.5 * at.rise());
  return drag(*world.laws.drag, world.annulus, eccentricity, at.length);
}

double drag_at_gap(const World& world, const Posture& at) {
  return drag_coefficients(world, at).axial * at.speed;
}

double meniscus_at_gap(const World& world, const Posture& at) {
  return at.length > 0 ? meniscus(*world.laws.meniscus, world.annulus.fibre_radius) : 0;
}

// Of a gas as if it were not compressed, which is the most that it can be.
double flow_at_gap(const World& world, const Posture& at) {
  const double c = world.annulus.clearance() + world.annulus.roughness;
  const double near = world.annulus.clearance() - at.gap, far = near - at.rise();
  const double square = (near * near + near * far + far * far) / (3 * c * c);
  const double area = flow_area(world.annulus);
  return area * area * at.speed *
         flow_resistance(*world.laws.flow, world.annulus, world.profile.length, at.length,
                         std::min(1.0, square));
}

// Of one that the fibre has passed, where the gap is the smallest at its end.
double particle_at_gap(const World& world, const Posture& at) {
  const Particle& law = *world.laws.particle;
  if (!(at.length > law.depth)) return 0;
  const double gap = at.gap + (at.length - law.depth) * at.tilt;
  return particle_push(law, law.height - gap).force;
}

}  // namespace

void expect_fits(const World& world, double gap_nm, double length_um, double tilt_mrad) {
  const Laws& laws = world.laws;
  const bool walls = std::holds_alternative<VanDerWaals>(laws.van_der_waals) ||
                     std::holds_alternative<Electrostatic>(laws.electrostatic) ||
                     std::holds_alternative<Capillary>(laws.capillary) || depends_on_speed(laws);
  const double clearance = 1e9 * world.annulus.clearance(), slack = 1e-9 * clearance;
  if (!walls && tilt_mrad == 0) return;
  if (gap_nm > clearance + slack)
    refuse_posture("--gap-nm ", gap_nm, ": the smallest gap is at most the clearance, ", clearance,
                   " nm");
  if (gap_nm + 0.5 * length_um * tilt_mrad > clearance + slack)
    refuse_posture("--tilt-mrad ", tilt_mrad, ": over ", length_um, " um a gap of ", gap_nm,
                   " nm would not be the smallest; at most ", 2 * (clearance - gap_nm) / length_um,
                   " mrad fit");
}

void expect_in_bore(const World& world, double length_um) {
  const double longest = 1e6 * world.profile.length;
  if (length_um > longest * (1 + 1e-9))
    refuse_posture("--length-um ", length_um, ": the bore is ", longest,
                   " um long (ferrule.length_mm)");
}

double mean_line_force(const std::function<double(double)>& law, const World& world, double reach,
                       const Posture& at) {
  const double rise = at.rise(), clearance = world.annulus.clearance();
  if (rise == 0) return law(at.gap);
  // The gap widens in a straight line; beyond the bore's axis the opposite wall is the near one.
  // Gauss-Legendre between the gaps where the law ends and between those that are an octave apart.
  std::vector<double> cuts = {0, 1};
  const auto cut = [&](double h) {
    for (const double there : {h, 2 * clearance - h})
      if (const double part = (there - at.gap) / rise; part > 0 && part < 1) cuts.push_back(part);
  };
  for (double h = kInteratomicDistance; h < clearance; h *= 2) cut(h);
  cut(clearance);
  cut(reach);
  std::sort(cuts.begin(), cuts.end());
  static const Quadrature nodes = Quadrature::gauss_legendre(kMostNodes);
  double sum = 0;
  for (std::size_t i = 1; i < cuts.size(); ++i) {
    const double width = cuts[i] - cuts[i - 1];
    for (std::size_t n = 0; n < kMostNodes; ++n) {
      const double h = at.gap + rise * (cuts[i - 1] + width * nodes.node[n]);
      sum += width * nodes.weight[n] * (h > clearance ? -law(2 * clearance - h) : law(h));
    }
  }
  return sum;
}

double force_at_gap(const World& world, Term term, const Posture& posture) {
  switch (term) {
    case Term::van_der_waals:
      return van_der_waals_at_gap(world, posture);
    case Term::electrostatic:
      return electrostatic_at_gap(world, posture);
    case Term::gravity:
      return gravity_at_gap(world, posture);
    case Term::capillary:
      return capillary_at_gap(world, posture);
    case Term::adhesion:
      return adhesion_at_gap(world, posture);
    case Term::wall:
      return wall_at_gap(world, posture);
    case Term::friction:
      return friction_at_gap(world, posture);
    case Term::drag:
      return drag_at_gap(world, posture);
    case Term::meniscus:
      return meniscus_at_gap(world, posture);
    case Term::flow:
      return flow_at_gap(world, posture);
    case Term::particle:
      return particle_at_gap(world, posture);
  }
  return 0;
}

GapForces gap_forces(const World& world, const Posture& posture) {
  GapForces forces;
  for (const Term term : kAllTerms)
    if (info(term).present(world.laws))
      forces.terms[static_cast<std::size_t>(term)] =
          force_at_gap(world, term, posture) + 0.0;  // no -0
  if (world.laws.drag) forces.squeeze = drag_coefficients(world, posture).radial * posture.speed;
  return forces;
}

}  // namespace ferrule
