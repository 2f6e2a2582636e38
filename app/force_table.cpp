#include "app/force_table.hpp"

#include <cmath>

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
  return world.adhesion && world.adhesion->contact ? world.adhesion->contact->curve.branches() : 0;
}

}  // namespace

ForceRow force_row(const World& world, double gap_nm, double length_um,
                   std::optional<double> depth_nm, double tilt) {
  ForceRow row{gap_nm, length_um, depth_nm, 0, 0, 0, 0, 0, 0, 0};
  const double gap = 1e-9 * gap_nm, length = 1e-6 * length_um;
  // Printed laws know one gap, that at the middle; corrected ones are integrated along the length.
  static const Quadrature middle, fine = Quadrature::gauss_legendre(kMostNodes);
  const auto along = [&](Form form, const auto& force) {
    const Quadrature& q = form == Form::printed || tilt == 0 ? middle : fine;
    double sum = 0;
    for (std::size_t n = 0; n < static_cast<std::size_t>(q.order); ++n)
      sum += q.weight[n] * force(gap + tilt * q.node[n] * length);
    return length * sum;
  };
  if (length > 0) {
    const Annulus& annulus = world.annulus;
    if (const auto& law = world.van_der_waals)
      row.van_der_waals =
          along(law->form, [&](double h) { return van_der_waals(*law, annulus, h).force; });
    if (const auto& law = world.electrostatic)
      row.electrostatic =
          along(law->form, [&](double h) { return electrostatic(*law, annulus, h).force; });
    if (const auto& law = world.capillary)
      row.capillary =
          along(law->form, [&](double h) { return capillary(*law, annulus, h, true).force; });
  }
  // Towards the wall below the fibre.
  if (world.gravity) row.gravity = -gravity(*world.gravity, world.fibre);
  if (depth_nm) {
    const double depth = 1e-9 * *depth_nm;
    const int branch = contact_branch(world);
    if (world.adhesion) row.adhesion = adhesion(*world.adhesion, depth, branch).force;
    if (world.wall) row.wall = wall(*world.wall, depth).force;
    if (world.friction)
      row.friction = friction(*world.friction, friction_radius(world, depth, branch));
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
          {"friction_uN", kMicro * row.friction}};
}

}  // namespace ferrule
