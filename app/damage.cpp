#include "app/damage.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

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
  return {first_of(scene, sharpest), first_of(scene, roundest), sharpest, roundest};
}

std::string to_text(const FirstDamage& d) {
  if (d.sharpest_um == d.roundest_um)
    return fmt::format("{} at {:.4g} uN (edge of {:g} um)", d.sharpest.name, 1e6 * d.sharpest.force,
                       d.sharpest_um);
  return fmt::format(
      "{} from {:.4g} uN (edge of {:g} um, as cleaved) to {:.4g} uN ({:g} um, polished)",
      d.sharpest.name, 1e6 * d.sharpest.force, d.sharpest_um, 1e6 * d.roundest.force,
      d.roundest_um);
}

std::string damage_note(const Scene& scene) {
  const FirstDamage damage = first_damage(scene);
  if (!(scene.limits.force > damage.sharpest.force)) return "";
  const bool surely = scene.limits.force > damage.roundest.force;
  return fmt::format(
      "note: limits.force_uN = {:g}: the fibre {} damaged before: {}; see ferrule limits\n",
      1e6 * scene.limits.force, surely ? "is" : "may be", to_text(damage));
}

Json damage_json(const Scene& scene) {
  const FirstDamage d = first_damage(scene);
  return {{"by", d.roundest.name},
          {"force_uN", 1e6 * d.roundest.force},
          {"over_limit", d.roundest.force / scene.limits.force},
          {"sharpest_by", d.sharpest.name},
          {"sharpest_force_uN", 1e6 * d.sharpest.force},
          {"edge_um", {d.sharpest_um, d.roundest_um}},
          {"text", to_text(d)}};
}

}  // namespace ferrule
