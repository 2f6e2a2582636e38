#include "sim/gap_forces.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <vector>

#include "sim/error.hpp"
#include "sim/scene/terms.hpp"

namespace ferrule {
namespace {

template <class... Parts>
[[noreturn]] void refuse_posture(const Parts&... parts) {
  std::ostringstream text;
  (text << ... << parts);
  throw BadInput(text.str());
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

GapForces gap_forces(const World& world, const Posture& posture) {
  GapForces forces;
  for (const Term term : kAllTerms)
    if (info(term).present(world.laws))
      forces.terms[static_cast<std::size_t>(term)] =
          info(term).at_gap(world, posture) + 0.0;  // no -0
  if (world.laws.drag) forces.squeeze = squeeze_at_gap(world, posture);
  return forces;
}

}  // namespace ferrule
