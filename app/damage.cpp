#include "app/damage.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim/analysis/damage.hpp"
#include "sim/laws/adhesion.hpp"

namespace ferrule {
namespace {

constexpr double kProofStress = 0.69;  // usual for telecom fibre [GPa]
constexpr double kEdge = 1;            // polished [um]

Damage first_damage(const Scene& scene) {
  const auto all = damages(scene, damage_input(scene));
  return *std::min_element(all.begin(), all.end(),
                           [](const Damage& a, const Damage& b) { return a.force < b.force; });
}

}  // namespace

DamageInput damage_input(const Scene& scene) {
  const double stated = scene.limits.proof_stress;
  return {std::isfinite(stated) ? 1e-9 * stated : kProofStress,
          scene.parameters.fibre.edge_um.value_or(kEdge)};
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

std::string damage_note(const Scene& scene) {
  const Damage first = first_damage(scene);
  if (!(scene.limits.force > first.force)) return "";
  return fmt::format(
      "note: limits.force_uN = {:g}: above the {:.4g} uN at which the fibre is damaged ({}; see "
      "ferrule limits)\n",
      1e6 * scene.limits.force, 1e6 * first.force, first.name);
}

Json damage_json(const Scene& scene) {
  const Damage first = first_damage(scene);
  return {{"by", first.name},
          {"force_uN", 1e6 * first.force},
          {"over_limit", first.force / scene.limits.force}};
}

}  // namespace ferrule
