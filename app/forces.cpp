// ferrule forces: force curves against gap, inserted length and penetration; or which force acted
// when in a recording.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "app/force_history_table.hpp"
#include "app/force_table.hpp"
#include "app/interrupt.hpp"
#include "app/output.hpp"
#include "app/progress.hpp"
#include "app/scene_arguments.hpp"
#include "app/validators.hpp"
#include "app/verbs.hpp"
#include "sim/scene/setting.hpp"
#include "sim/scene/terms.hpp"

namespace ferrule {
namespace {

struct ForcesArguments {
  SceneArguments scene;
  std::string episode, against, form, gap, length, depth, plot;
  double tilt_mrad = 0, speed_um_s = 10;
  std::string of_curves;  // an option that was given and is not for recordings
  Output output;
};

constexpr double kMostRows = 2e5;  // some 400 MB as JSON

std::vector<double> lengths(const std::string& text, const std::string& option) {
  std::vector<double> values = parse_range(text, option);
  for (const double v : values)
    if (v < 0) throw BadInput(option + " " + text + ": must not be negative");
  return values;
}

void print_table(const std::vector<ForceRow>& rows, const Laws& laws) {
  std::vector<Term> shown;
  for (const Term term : kAllTerms)
    if (info(term).present(laws)) shown.push_back(term);
  fmt::print("{:>9} {:>9} {:>8}", "gap_nm", "length_um", "depth_nm");
  for (const Term term : shown) fmt::print(" {:>13}", info(term).name);
  if (laws.drag) fmt::print(" {:>13}", "squeeze");
  fmt::print("\n");
  for (const ForceRow& r : rows) {
    fmt::print("{:9.4g} {:9.4g} {:>8}", r.gap_nm, r.length_um,
               r.depth_nm ? fmt::format("{:.4g}", *r.depth_nm) : "-");
    for (const Term term : shown) fmt::print(" {:13.6g}", 1e6 * r.forces[term]);
    if (laws.drag) fmt::print(" {:13.6g}", 1e6 * r.forces.squeeze);
    fmt::print("\n");
  }
  fmt::print(
      "forces in uN; attraction negative; friction, meniscus, drag and flow magnitudes; \"-\": not "
      "in "
      "contact\n");
}

// Nothing is left out. The settings are those of the form asked for.
Scene scene_in_form(const ForcesArguments& a) {
  if (a.form.empty()) return a.scene.load();
  Json document = load_scene(a.scene.name()).document();
  for (const std::string& setting : a.scene.settings) apply_setting(document, setting);
  const std::string file = a.scene.name() + " with --form " + a.form;
  set_form(document, a.form == "printed" ? Form::printed : Form::corrected, file);
  return parse_scene(document, file);
}

// What is swept: one of the three, or each combination of them.
struct Grid {
  std::vector<double> gaps, inserted, depths;  // no depths: apart
};

Grid grid(const ForcesArguments& a) {
  Grid g;
  if (!a.depth.empty()) g.depths = lengths(a.depth, "--depth-nm");
  // In contact the gap is closed, unless one is asked for.
  g.gaps = lengths(!a.gap.empty() ? a.gap : g.depths.empty() ? "10" : "0", "--gap-nm");
  g.inserted = lengths(a.length, "--length-um");
  return g;
}

// As far as Ctrl-C lets it.
std::vector<ForceRow> force_rows(const World& world, const Grid& grid, const ForcesArguments& a) {
  const double all = static_cast<double>(grid.gaps.size()) *
                     static_cast<double>(grid.inserted.size()) *
                     static_cast<double>(std::max<std::size_t>(1, grid.depths.size()));
  if (all > kMostRows)
    throw BadInput(fmt::format("{:.4g} rows are asked for; at most {:.0f}", all, kMostRows));
  for (const double length : grid.inserted) expect_in_bore(world, length);
  for (const double gap : grid.gaps)
    for (const double length : grid.inserted) expect_fits(world, gap, length, a.tilt_mrad);
  const double tilt = 1e-3 * a.tilt_mrad, speed = 1e-6 * a.speed_um_s;
  std::vector<ForceRow> rows;
  Progress progress("computing", static_cast<std::size_t>(all));
  const auto add = [&](double gap, double length, std::optional<double> depth) {
    if (interrupted()) return;
    rows.push_back(force_row(world, gap, length, depth, tilt, speed));
    progress(rows.size());
  };
  for (const double gap : grid.gaps)
    for (const double length : grid.inserted) {
      if (grid.depths.empty()) add(gap, length, std::nullopt);
      for (const double depth : grid.depths) add(gap, length, depth);
    }
  return rows;
}

Sweep swept(const Grid& grid) {
  const bool gap = grid.gaps.size() > 1, length = grid.inserted.size() > 1;
  if (gap + length + (grid.depths.size() > 1) != 1)
    throw BadInput("--plot needs exactly one range among gap, length and depth");
  return gap ? Sweep::gap : length ? Sweep::length : Sweep::depth;
}

// A recording, and the scene that it was made in.
struct RecordedInsertion {
  Episode episode;
  Scene scene;
};
RecordedInsertion read_insertion(const std::string& file) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error))
    throw BadInput(file + ": is a folder; name one recording of it");
  Episode episode = read_episode(file);
  Scene scene = recorded_scene(episode.info, file);
  if (episode.rows.rows() == 0) throw BadInput(file + ": has no rows");
  return {std::move(episode), std::move(scene)};
}

// Which force acted when.
int forces_of_recording(const ForcesArguments& a) {
  if (!a.of_curves.empty())
    throw BadInput(a.of_curves + ": of force curves; a recording has its own scene and gaps");
  const auto [episode, scene] = read_insertion(a.episode);
  const ForceHistory history = force_history(episode, scene);
  std::optional<FeltDifference> difference;
  if (!a.against.empty()) {
    const auto [other, in] = read_insertion(a.against);
    difference = felt_difference(episode, scene, other, in);
  }
  if (!a.plot.empty()) write_plot(a.plot, history_plot(episode, scene));
  Provenance provenance;
  provenance.in({scene, "", ", as recorded"}).read(a.episode);
  if (difference) provenance.read(a.against);
  if (a.output.text())
    fmt::print("{}{}{}{}", provenance.head(), to_text(history),
               difference ? printable(a.against) + ": " + to_text(*difference) : "",
               provenance.foot());
  Json result = {
      {"file", a.episode},
      {"scene", scene.name},
      {"rows", episode.rows.rows()},
      {"share_touching", history.touching},
      {"felt_median_uN", 1e6 * history.felt_median},
      {"felt_largest_uN", 1e6 * history.felt_largest},
      {"terms", json_list(history.terms, [](const TermActivity& t) { return to_json(t); })}};
  if (difference) {
    result["against"] = to_json(*difference);
    result["against"]["file"] = a.against;
  }
  print_result(a.output, result, "terms", provenance);
  return kDone;
}

// What is no force at a gap: of the fibre's curl.
Json curl_json(const FreeCurl& curl) {
  return {{"aside_um", 1e6 * curl.aside},
          {"tilt_mrad", 1e3 * curl.tilt},
          {"straightening_uN", 1e6 * curl.force}};
}

// What the curves take for granted of the parts of a scene.
void print_parts(const Scene& scene) {
  if (const auto& particle = scene.world.laws.particle)
    fmt::print("particle: {:.4g} um high{}, and the fibre comes near on its side\n",
               1e6 * particle->height,
               std::isnan(scene.parameters.laws.particle->height)
                   ? ", as high as is met once in 50 trials or as the clearance"
                   : "");
  if (scene.parameters.fibre.cleave_deg.value_or(0) > 0 || !scene.world.oval.round())
    fmt::print("as of a square end in a round bore: cleave and ovality are not in these numbers\n");
}

int forces_verb(const ForcesArguments& a) {
  if (!a.episode.empty()) return forces_of_recording(a);
  if (!a.against.empty())
    throw BadInput("--against " + a.against + ": of a recording; none is named");
  const Scene scene = scene_in_form(a);
  const Grid asked = grid(a);
  const std::vector<ForceRow> rows = force_rows(scene.world, asked, a);
  if (!a.plot.empty() && !interrupted())
    write_plot(a.plot, force_plot(rows, swept(asked), scene.name));
  const auto curl = free_curl(scene.parameters);
  Provenance provenance;
  provenance.in({scene, scene_file(a.scene.name())});
  if (interrupted()) provenance.partial(fmt::format("{} rows", rows.size()));
  if (a.output.text()) {
    fmt::print("{}", provenance.head());
    print_table(rows, scene.world.laws);
    if (curl)
      fmt::print(
          "curl: the free end lies {:.4g} um aside and tilts by {:.4g} mrad; {:.4g} uN across "
          "it hold it straight\n",
          1e6 * curl->aside, 1e3 * curl->tilt, 1e6 * curl->force);
    print_parts(scene);
    fmt::print("{}", provenance.foot());
  }
  Json json = {{"scene", scene.name},
               {"rows", json_list(rows, [](const ForceRow& r) { return to_json(r); })}};
  if (curl) json["curl"] = curl_json(*curl);
  print_result(a.output, json, "rows", provenance);
  return interrupted() ? kInterrupted : kDone;
}

}  // namespace

void add_forces(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand(
      "forces", "Force curves of a scene, or which force acted when in a recording");
  auto a = std::make_shared<ForcesArguments>();
  verb->add_option("episode", a->episode,
                   "Recording: which force acted when, and how much of it "
                   "reached the hand")
      ->type_name("FILE.h5");
  verb->add_option("--against", a->against,
                   "Another recording: would a hand have felt the difference?")
      ->type_name("FILE.h5");
  a->scene.add_to(*verb);
  a->length = "100";
  verb->add_option("--form", a->form, "Form of all laws, instead of the scene's")
      ->check(one_of({"printed", "corrected"}));
  const char* range = "VALUE|FROM:TO:COUNT[:log]";
  verb->add_option("--gap-nm", a->gap, "Smallest gap; 10 unless given")->type_name(range);
  verb->add_option("--length-um", a->length, "Inserted length")
      ->capture_default_str()
      ->type_name(range);
  verb->add_option("--depth-nm", a->depth, "Penetration, for a closed contact")->type_name(range);
  verb->add_option("--tilt-mrad", a->tilt_mrad,
                   "Angle between the axes; the gap is the smallest then")
      ->capture_default_str()
      ->check(number_between(0, 100));
  verb->add_option("--speed-um-s", a->speed_um_s,
                   "Speed for drag and flow: along the bore, and towards the wall (squeeze)")
      ->capture_default_str()
      ->check(number_between(0, 1e9));
  add_output(*verb, a->output);
  add_plot(*verb, a->plot, "Draw the curves");
  add_examples(*verb, {"forces --scene paper --gap-nm 1:500:50:log --plot gap.svg",
                       "forces --scene demo --depth-nm 0:12:13 --csv",
                       "forces episodes/episode_0001.h5 --plot forces.svg"});
  verb->callback([a, verb, &run] {
    for (const char* of_curves : {"--scene", "--set", "--form", "--gap-nm", "--length-um",
                                  "--depth-nm", "--tilt-mrad", "--speed-um-s"})
      if (verb->count(of_curves) > 0) a->of_curves = of_curves;
    run.verb = [a] { return forces_verb(*a); };
  });
}

}  // namespace ferrule
