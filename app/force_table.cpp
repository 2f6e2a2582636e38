#include "app/force_table.hpp"

#include <cmath>

#include "sim/scene/terms.hpp"

namespace ferrule {
namespace {

constexpr double kMicro = 1e6;  // newtons to uN

// What is drawn: apart, and in contact.
constexpr std::array kNonContact = {Term::van_der_waals, Term::electrostatic, Term::capillary,
                                    Term::gravity};
constexpr std::array kContact = {Term::adhesion, Term::wall, Term::friction, Term::gravity};

}  // namespace

ForceRow force_row(const World& world, double gap_nm, double length_um,
                   std::optional<double> depth_nm, double tilt, double speed) {
  Posture posture{1e-9 * gap_nm, 1e-6 * length_um, std::nullopt, tilt, speed};
  if (depth_nm) posture.depth = 1e-9 * *depth_nm;
  return {gap_nm, length_um, depth_nm, gap_forces(world, posture)};
}

Plot force_plot(const std::vector<ForceRow>& rows, Sweep sweep, const std::string& scene) {
  Axes axes;
  const bool contact = sweep == Sweep::depth;
  axes.x_label = sweep == Sweep::gap      ? "smallest gap h [nm]"
                 : sweep == Sweep::length ? "inserted length [um]"
                                          : "penetration d [nm]";
  axes.y_label = contact ? "force [uN], attraction negative" : "magnitude of force [uN]";
  axes.log_x = axes.log_y = sweep == Sweep::gap;
  for (const Term term : contact ? kContact : kNonContact) {
    Series series{info(term).label, {}, {}};
    bool present = false;
    for (const ForceRow& row : rows) {
      const double force = kMicro * row.forces[term];
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
  Json json = {{"gap_nm", row.gap_nm},
               {"length_um", row.length_um},
               {"depth_nm", row.depth_nm.value_or(0.0)},
               {"in_contact", row.depth_nm.has_value()},
               {"squeeze_uN", kMicro * row.forces.squeeze}};
  for (const Term term : kAllTerms)
    json[info(term).name + std::string("_uN")] = kMicro * row.forces[term];
  return json;
}

}  // namespace ferrule
