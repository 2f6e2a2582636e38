// ferrule limits: forces at which a fibre takes damage, beside the limit of a scene.
#include <fmt/format.h>

#include "app/damage.hpp"
#include "app/output.hpp"
#include "app/scene_arguments.hpp"
#include "app/validators.hpp"
#include "app/verbs.hpp"

namespace ferrule {
namespace {

struct LimitsArguments {
  SceneArguments scene;
  double edge_um = 0, stress_GPa = 0;  // 0: as the scene says
  Output output;
};

int limits_verb(const LimitsArguments& a) {
  const Scene scene = a.scene.load();
  DamageInput input = damage_input(scene);
  if (a.stress_GPa > 0) input.stress_GPa = a.stress_GPa;
  if (a.edge_um > 0) input.edge_um = a.edge_um;
  const auto rows = damages(scene, input);
  const bool edge_known = a.edge_um > 0 || scene.parameters.fibre.edge_um;
  Provenance provenance;
  provenance.in({scene, scene_file(a.scene.name())});
  if (a.output.text()) {
    fmt::print("{}{:<9} {:>12} {:>14}  {}\n", provenance.head(), "damage", "force_uN", "over limit",
               "where");
    for (const Damage& r : rows)
      fmt::print("{:<9} {:>12} {:>14}  {}\n", r.name, number_or("-", "{:.4g}", 1e6 * r.force),
                 number_or("-", "{:.4g}", r.force / scene.limits.force), r.what);
    fmt::print("limits.force_uN is {:g}; stress allowed {:g} GPa, edge rounded by {:g} um\n{}{}",
               1e6 * scene.limits.force, input.stress_GPa, input.edge_um,
               edge_known ? ""
                          : "the scene does not state fibre.edge_um: first damage " +
                                to_text(first_damage(scene)) + "\n",
               provenance.foot());
  }
  const auto json = [&](const Damage& r) {
    return Json{{"damage", r.name},
                {"force_uN", number_or_null(1e6 * r.force)},
                {"over_limit", number_or_null(r.force / scene.limits.force)},
                {"stress_GPa", input.stress_GPa},
                {"edge_um", input.edge_um}};
  };
  print_result(a.output,
               {{"scene", scene.name},
                {"force_limit_uN", 1e6 * scene.limits.force},
                {"stress_GPa", input.stress_GPa},
                {"edge_um", input.edge_um},
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
  verb->callback([a, &run] { run.verb = [a] { return limits_verb(*a); }; });
}

}  // namespace ferrule
