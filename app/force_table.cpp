#include "app/force_table.hpp"

#include <cmath>

namespace ferrule {
namespace {

constexpr double kMicro = 1e6;  // newtons to uN

struct Term {
  const char* name;
  double GapForces::*value;
};
constexpr Term kNonContact[] = {{"van der Waals", &GapForces::van_der_waals},
                                {"electrostatic", &GapForces::electrostatic},
                                {"capillary", &GapForces::capillary},
                                {"gravity", &GapForces::gravity}};
constexpr Term kContact[] = {{"adhesion", &GapForces::adhesion},
                             {"wall", &GapForces::wall},
                             {"friction", &GapForces::friction},
                             {"gravity", &GapForces::gravity}};

}  // namespace

ForceRow force_row(const World& world, double gap_nm, double length_um,
                   std::optional<double> depth_nm, const Lie& lie) {
  std::optional<double> depth;
  if (depth_nm) depth = 1e-9 * *depth_nm;
  return {gap_nm, length_um, depth_nm,
          gap_forces(world, 1e-9 * gap_nm, 1e-6 * length_um, depth, lie)};
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
      const double force = kMicro * (row.forces.*term.value);
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
  const GapForces& f = row.forces;
  return {{"gap_nm", row.gap_nm},
          {"length_um", row.length_um},
          {"depth_nm", row.depth_nm.value_or(0.0)},
          {"in_contact", row.depth_nm.has_value()},
          {"van_der_waals_uN", kMicro * f.van_der_waals},
          {"electrostatic_uN", kMicro * f.electrostatic},
          {"capillary_uN", kMicro * f.capillary},
          {"gravity_uN", kMicro * f.gravity},
          {"adhesion_uN", kMicro * f.adhesion},
          {"wall_uN", kMicro * f.wall},
          {"friction_uN", kMicro * f.friction},
          {"meniscus_uN", kMicro * f.meniscus},
          {"drag_uN", kMicro * f.drag},
          {"squeeze_uN", kMicro * f.squeeze}};
}

}  // namespace ferrule
