// ferrule limits: forces at which a fibre takes damage, beside the limit of a scene.
#include <fmt/format.h>

#include <array>
#include <cmath>

#include "app/verb.hpp"
#include "sim/damage.hpp"
#include "sim/laws/adhesion.hpp"

namespace ferrule {
namespace {

struct LimitsArguments {
  SceneArguments scene;
  double edge_um = 0, stress_GPa = 0;  // 0: as the scene says
  Output output;
};

constexpr double kProofStress = 0.69;  // usual for telecom fibre [GPa]
constexpr double kEdge = 1;            // polished [um]

struct LimitRow {
  const char *name, *what;
  double force;  // [N]
};

std::array<LimitRow, 4> limit_rows(const Scene& scene, double stress, double edge) {
  const FibreParameters& fibre = scene.parameters.fibre;
  const FerruleParameters& ferrule = scene.parameters.ferrule;
  const double K = reduced_modulus(1e9 * fibre.young_GPa, fibre.poisson, 1e9 * ferrule.young_GPa,
                                   ferrule.poisson);
  const DamageForces d = damage_forces(scene.world, K, fibre.poisson, stress, edge);
  return {{{"buckling", "axial: Euler's load of the free fibre", d.buckling},
           {"bending", "sideways: the stress allowed, at the holder", d.bending},
           {"ring", "on the end's edge: the stress allowed, around the contact", d.ring},
           {"chipping", "on the end's edge: a chip breaks off", d.chipping}}};
}

int limits_verb(const LimitsArguments& a) {
  const Scene scene = a.scene.load();
  const double stated = scene.limits.proof_stress;
  const double stress_GPa = a.stress_GPa > 0        ? a.stress_GPa
                            : std::isfinite(stated) ? 1e-9 * stated
                                                    : kProofStress;
  const double edge_um = a.edge_um > 0 ? a.edge_um : scene.parameters.fibre.edge_um.value_or(kEdge);
  const auto rows = limit_rows(scene, 1e9 * stress_GPa, 1e-6 * edge_um);
  Provenance provenance;
  provenance.in({scene, scene_file(a.scene.name())});
  if (a.output.text()) {
    fmt::print("{}{:<9} {:>12} {:>14}  {}\n", provenance.head(), "damage", "force_uN", "over limit",
               "where");
    for (const LimitRow& r : rows)
      fmt::print("{:<9} {:>12} {:>14}  {}\n", r.name, number_or("-", "{:.4g}", 1e6 * r.force),
                 number_or("-", "{:.4g}", r.force / scene.limits.force), r.what);
    fmt::print("limits.force_uN is {:g}; stress allowed {:g} GPa, edge rounded by {:g} um\n{}",
               1e6 * scene.limits.force, stress_GPa, edge_um, provenance.foot());
  }
  const auto json = [&](const LimitRow& r) {
    return Json{{"damage", r.name},
                {"force_uN", number_or_null(1e6 * r.force)},
                {"over_limit", number_or_null(r.force / scene.limits.force)},
                {"stress_GPa", stress_GPa},
                {"edge_um", edge_um}};
  };
  print_result(a.output,
               {{"scene", scene.name},
                {"force_limit_uN", 1e6 * scene.limits.force},
                {"stress_GPa", stress_GPa},
                {"edge_um", edge_um},
                {"rows", json_list(rows, json)}},
               "rows", provenance);
  return kDone;
}

}  // namespace

void add_limits(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand("limits", "Forces at which a fibre takes damage");
  auto a = std::make_shared<LimitsArguments>();
  a->scene.add_to(*verb);
  verb->add_option("--edge-um", a->edge_um,
                   "Radius of the end's edge; that of the scene, or 1, unless given")
      ->check(number_between(1e-4, 100));
  verb->add_option("--stress-GPa", a->stress_GPa,
                   "Stress that is allowed; the scene's proof stress, or 0.69, unless given")
      ->check(number_between(1e-6, 100));
  add_output(*verb, a->output);
  add_examples(*verb, {"limits --scene bench", "limits --scene bench --edge-um 0.02"});
  verb->callback([a, &run] { run = [a] { return limits_verb(*a); }; });
}

}  // namespace ferrule
