#include "app/damage.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/varied_plots.hpp"
#include "sim/analysis/damage.hpp"
#include "sim/laws/adhesion.hpp"

namespace ferrule {
namespace {

constexpr double kProofStress = 0.69;             // usual for telecom fibre [GPa]
constexpr double kPolished = 1, kCleaved = 0.02;  // radii of an edge [um]

Damage first_of(const Scene& scene, double edge_um) {
  const auto all = damages(scene, {damage_input(scene).stress_GPa, edge_um});
  return *std::min_element(all.begin(), all.end(),
                           [](const Damage& a, const Damage& b) { return a.force < b.force; });
}

// The limit on the force [N]; the highest one where chance decides it.
double highest_limit(const Scene& scene) {
  double limit = scene.limits.force;
  for (const DrawnNumber& number : scene.drawn)
    if (number.key == "limits.force_uN")
      for (const double uN : number.distribution.extremes()) limit = std::max(limit, 1e-6 * uN);
  return limit;
}

// Does damage depend on what chance decides?
bool at_centre(const Scene& scene) {
  constexpr std::array kOn = {"fibre.", "holder.", "limits.proof_stress", "ferrule.young",
                              "ferrule.poisson"};
  return std::any_of(scene.drawn.begin(), scene.drawn.end(), [&](const DrawnNumber& number) {
    return !number.implied && std::any_of(kOn.begin(), kOn.end(), [&](const char* on) {
      return number.key.starts_with(on);
    });
  });
}

}  // namespace

DamageInput damage_input(const Scene& scene) {
  const double stated = scene.limits.proof_stress;
  return {std::isfinite(stated) ? 1e-9 * stated : kProofStress,
          scene.parameters.fibre.edge_um.value_or(kPolished)};
}

std::array<Damage, 4> damages(const Scene& scene, const DamageInput& input) {
  const FibreParameters& fibre = scene.parameters.fibre;
  const FerruleParameters& ferrule = scene.parameters.ferrule;
  const double K = reduced_modulus(1e9 * fibre.young_GPa, fibre.poisson, 1e9 * ferrule.young_GPa,
                                   ferrule.poisson);
  const DamageForces d =
      damage_forces(scene.world, K, fibre.poisson, 1e9 * input.stress_GPa, 1e-6 * input.edge_um);
  return {{{"buckling", "axial: Euler's load of the free fibre", d.buckling},
           {"bending", "sideways: the stress allowed, at the holder", d.bending},
           {"ring", "on the end's edge: the stress allowed, around the contact", d.ring},
           {"chipping", "on the end's edge: a chip breaks off", d.chipping}}};
}

FirstDamage first_damage(const Scene& scene) {
  const std::optional<double>& stated = scene.parameters.fibre.edge_um;
  const double sharpest = stated.value_or(kCleaved), roundest = stated.value_or(kPolished);
  return {first_of(scene, sharpest), first_of(scene, roundest), sharpest, roundest,
          at_centre(scene)};
}

std::string to_text(const FirstDamage& d) {
  const char* drawn = d.at_centre ? ", with what is drawn at its centre" : "";
  if (d.sharpest_um == d.roundest_um)
    return fmt::format("{} at {:.4g} uN (edge of {:g} um){}", d.sharpest.name,
                       1e6 * d.sharpest.force, d.sharpest_um, drawn);
  return fmt::format(
      "{} from {:.4g} uN (edge of {:g} um, as cleaved) to {:.4g} uN ({:g} um, polished){}",
      d.sharpest.name, 1e6 * d.sharpest.force, d.sharpest_um, 1e6 * d.roundest.force, d.roundest_um,
      drawn);
}

std::string damage_note(const Scene& scene) {
  const FirstDamage damage = first_damage(scene);
  const double limit = highest_limit(scene);
  if (!(limit > damage.sharpest.force)) return "";
  const bool drawn = limit != scene.limits.force, surely = limit > damage.roundest.force;
  return fmt::format(
      "note: limits.force_uN = {}: the fibre {} damaged before: {}; see ferrule limits\n",
      drawn ? setting_text(scene.document().at("limits").at("force_uN"))
            : fmt::format("{:g}", 1e6 * limit),
      surely && !drawn ? "is" : "may be", to_text(damage));
}

Json damage_json(const Scene& scene) {
  const FirstDamage d = first_damage(scene);
  return {{"by", d.roundest.name},
          {"force_uN", 1e6 * d.roundest.force},
          {"over_limit", d.roundest.force / highest_limit(scene)},
          {"sharpest_by", d.sharpest.name},
          {"sharpest_force_uN", 1e6 * d.sharpest.force},
          {"edge_um", {d.sharpest_um, d.roundest_um}},
          {"limit_uN", scene.document().at("limits").at("force_uN")},
          {"text", to_text(d)}};
}

}  // namespace ferrule
