// ferrule release: what it takes to break the contact.
#include "sim/analysis/release.hpp"

#include <fmt/format.h>

#include "app/output.hpp"
#include "app/scene_arguments.hpp"
#include "app/validators.hpp"
#include "app/verbs.hpp"
#include "sim/analysis/gap_forces.hpp"
#include "sim/scene/terms.hpp"

namespace ferrule {
namespace {

struct ReleaseArguments {
  SceneArguments scene;
  double length_um = 100, speed_um_s = 0;
  int places = 2;
  Output output;
};

Json to_json(const Release& r, const Laws& laws) {
  Json json = {{"path", kReleasePaths[static_cast<std::size_t>(r.path)]},
               {"force_uN", 1e6 * r.force},
               {"separation_nm", 1e9 * r.separation}};
  for (const Term term : kAllTerms)
    if (info(term).present(laws) && term != Term::wall)
      json[info(term).name + std::string("_uN")] = 1e6 * r.terms[static_cast<std::size_t>(term)];
  return json;
}

void print(const std::vector<Release>& rows, const Laws& laws) {
  std::vector<Term> shown;
  for (const Term term : kAllTerms)
    if (info(term).present(laws) && term != Term::wall) shown.push_back(term);
  fmt::print("{:<6} {:>11} {:>13}", "path", "force_uN", "separation_nm");
  for (const Term term : shown) fmt::print(" {:>13}", info(term).name);
  fmt::print("\n");
  for (const Release& r : rows) {
    fmt::print("{:<6} {:>11.5g} {:>13.4g}", kReleasePaths[static_cast<std::size_t>(r.path)],
               1e6 * r.force, 1e9 * r.separation);
    for (const Term term : shown)
      fmt::print(" {:>13.5g}", 1e6 * r.terms[static_cast<std::size_t>(term)]);
    fmt::print("\n");
  }
}

// One place of contact by itself, beside its limits.
struct PullOff {
  double force, jkr, dmt;  // [N]
};
std::optional<PullOff> pull_off(const Laws& laws) {
  const auto* law = std::get_if<Adhesion>(&laws.adhesion);
  if (!law) return std::nullopt;
  const double unit = law->contact->force;  // pi w R_s
  return PullOff{-unit * law->contact->curve.pull_off_force(), 1.5 * unit, 2 * unit};
}

int release_verb(const ReleaseArguments& a) {
  const Scene scene = a.scene.load();
  expect_in_bore(scene.world, a.length_um);
  const std::vector<Release> rows =
      release(scene.world, 1e-6 * a.length_um, a.places, 1e-6 * a.speed_um_s);
  const std::optional<PullOff> alone = pull_off(scene.world.laws);
  Provenance provenance;
  provenance.in({scene, scene_file(a.scene.name())});
  if (a.output.text()) {
    fmt::print("{}", provenance.head());
    print(rows, scene.world.laws);
    fmt::print(
        "what it takes to part a fibre {:g} um inserted from the wall below it, and what "
        "holds it there, in uN\n",
        a.length_um);
    if (alone)
      fmt::print("one place of contact alone: {:.4g} uN; JKR {:.4g} uN, DMT {:.4g} uN\n",
                 1e6 * alone->force, 1e6 * alone->jkr, 1e6 * alone->dmt);
    fmt::print("{}", provenance.foot());
  }
  Json json = {
      {"scene", scene.name},
      {"length_um", a.length_um},
      {"places", a.places},
      {"rows", json_list(rows, [&](const Release& r) { return to_json(r, scene.world.laws); })}};
  if (alone) {
    json["pull_off_uN"] = 1e6 * alone->force;
    json["jkr_uN"] = 1e6 * alone->jkr;
    json["dmt_uN"] = 1e6 * alone->dmt;
  }
  print_result(a.output, json, "rows", provenance);
  return kDone;
}

}  // namespace

void add_release(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand("release", "What it takes to break the contact, path by path");
  auto a = std::make_shared<ReleaseArguments>();
  a->scene.add_to(*verb);
  verb->add_option("--length-um", a->length_um, "Inserted length")
      ->capture_default_str()
      ->check(number_between(0, 1e6));
  verb->add_option("--places", a->places,
                   "Places of contact: 1, the end or the side alone; 2, both")
      ->capture_default_str()
      ->check(whole_number(1, 2));
  verb->add_option("--speed-um-s", a->speed_um_s, "Speed of sliding, for drag")
      ->capture_default_str()
      ->check(number_between(0, 1e9));
  add_output(*verb, a->output);
  add_examples(*verb, {"release --scene bench", "release --scene sticky --length-um 500 --json"});
  verb->callback([a, &run] { run.verb = [a] { return release_verb(*a); }; });
}

}  // namespace ferrule
