#include "app/force_table.hpp"

#include <algorithm>
#include <cmath>

#include "sim/laws/printed/range.hpp"

namespace ferrule {
namespace {

constexpr double kMicro = 1e6;  // newtons to uN

struct Term {
  const char* name;
  double ForceRow::*value;
};
constexpr Term kNonContact[] = {{"van der Waals", &ForceRow::van_der_waals},
                                {"electrostatic", &ForceRow::electrostatic},
                                {"capillary", &ForceRow::capillary},
                                {"gravity", &ForceRow::gravity}};
constexpr Term kContact[] = {{"adhesion", &ForceRow::adhesion},
                             {"wall", &ForceRow::wall},
                             {"friction", &ForceRow::friction},
                             {"gravity", &ForceRow::gravity}};

// The branch on which the surfaces touch.
int contact_branch(const World& world) {
  return world.laws.adhesion && world.laws.adhesion->contact
             ? world.laws.adhesion->contact->curve.branches()
             : 0;
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
  for (double h = kInteratomicDistance; h < clearance; h *= 2) cut(h);
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

ForceRow force_row(const World& world, double gap_nm, double length_um,
                   std::optional<double> depth_nm, const Lie& lie) {
  ForceRow row{gap_nm, length_um, depth_nm, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  const Annulus& annulus = world.annulus;
  const double gap = 1e-9 * gap_nm, length = 1e-6 * length_um, rise = length * lie.tilt;
  const auto along = [&](Form form, double reach, const auto& law) {
    if (length == 0) return 0.0;
    if (form == Form::printed || rise == 0) return length * law(gap + 0.5 * rise);
    return length * mean_force(law, annulus.clearance(), reach, gap, rise);
  };
  if (const auto& law = world.laws.van_der_waals)
    row.van_der_waals =
        along(law->form, 0, [&](double h) { return van_der_waals(*law, annulus, h).force; });
  if (const auto& law = world.laws.electrostatic)
    row.electrostatic =
        along(law->form, 0, [&](double h) { return electrostatic(*law, annulus, h).force; });
  if (const auto& law = world.laws.capillary)
    row.capillary = along(law->form, capillary_reach(*law, true),
                          [&](double h) { return capillary(*law, annulus, h, true).force; });
  if (length > 0 && world.laws.meniscus)
    row.meniscus = meniscus(*world.laws.meniscus, annulus.fibre_radius);
  if (world.laws.drag) {
    const double eccentricity = std::abs(annulus.clearance() - gap - 0.5 * rise);
    const DragCoefficients k = drag(*world.laws.drag, annulus, eccentricity, length);
    row.drag = k.axial * lie.speed;
    row.squeeze = k.radial * lie.speed;
  }
  // Towards the wall below the fibre.
  if (world.laws.gravity) row.gravity = -gravity(*world.laws.gravity, world.fibre);
  if (depth_nm) {
    const double depth = 1e-9 * *depth_nm;
    const int branch = contact_branch(world);
    if (world.laws.adhesion) row.adhesion = adhesion(*world.laws.adhesion, depth, branch).force;
    if (world.laws.wall) row.wall = wall(*world.laws.wall, depth).force;
    if (world.laws.friction)
      row.friction = friction(*world.laws.friction, friction_radius(world, depth, branch));
  }
  return row;
}

Plot force_plot(const std::vector<ForceRow>& rows, Sweep sweep, const std::string& scene) {
  Axes axes;
  const bool contact = sweep == Sweep::depth;
  axes.x_label = sweep == Sweep::gap      ? "smallest gap h [nm]"
                 : sweep == Sweep::length ? "inserted length [um]"
                                          : "penetration d [nm]";
  axes.y_label = contact ? "force [uN], attraction negative" : "magnitude of force [uN]";
  axes.log_x = axes.log_y = sweep == Sweep::gap;
  for (const Term& term : contact ? kContact : kNonContact) {
    Series series{term.name, {}, {}};
    bool present = false;
    for (const ForceRow& row : rows) {
      const double force = kMicro * (row.*term.value);
      present = present || force != 0;
      series.x.push_back(sweep == Sweep::gap      ? row.gap_nm
                         : sweep == Sweep::length ? row.length_um
                                                  : row.depth_nm.value_or(0));
      series.y.push_back(contact ? force : std::abs(force));
    }
    if (present) axes.series.push_back(series);
  }
  if (axes.series.empty()) throw BadInput("nothing to plot: the scene has none of these forces");
  return {"Forces in the scene " + scene, {axes}};
}

Json to_json(const ForceRow& row) {
  return {{"gap_nm", row.gap_nm},
          {"length_um", row.length_um},
          {"depth_nm", row.depth_nm.value_or(0.0)},
          {"in_contact", row.depth_nm.has_value()},
          {"van_der_waals_uN", kMicro * row.van_der_waals},
          {"electrostatic_uN", kMicro * row.electrostatic},
          {"capillary_uN", kMicro * row.capillary},
          {"gravity_uN", kMicro * row.gravity},
          {"adhesion_uN", kMicro * row.adhesion},
          {"wall_uN", kMicro * row.wall},
          {"friction_uN", kMicro * row.friction},
          {"meniscus_uN", kMicro * row.meniscus},
          {"drag_uN", kMicro * row.drag},
          {"squeeze_uN", kMicro * row.squeeze}};
}

}  // namespace ferrule
