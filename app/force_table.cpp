#include "app/force_table.hpp"

#include <cmath>

#include "sim/surface_forces.hpp"

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
  const double c = world.annulus.clearance();
  if (length > 0 && tilt == 0) {
    if (const auto& law = world.van_der_waals)
      row.van_der_waals = length * van_der_waals(*law, world.annulus, gap).force;
    if (const auto& law = world.electrostatic)
      row.electrostatic = length * electrostatic(*law, world.annulus, gap).force;
    if (const auto& law = world.capillary)
      row.capillary = length * capillary(*law, world.annulus, gap, true).force;
  } else if (length > 0) {
    // A fibre that leans away from the wall below it; the gap changes by decades along it.
    World fine = world;
    fine.quadrature = Quadrature::gauss_legendre(kMostNodes);
    Pose tip;
    tip << -length, gap - c, 0, tilt, 0;
    Energy energy;
    SurfaceGradients terms;
    add_surface_forces(energy, terms, fine, length, true, tip);
    row.van_der_waals = -terms[kVanDerWaals].e.x();
    row.electrostatic = -terms[kElectrostatic].e.x();
    row.capillary = -terms[kCapillary].e.x();
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
