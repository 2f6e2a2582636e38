// ferrule forces: force curves against gap, inserted length and penetration.
#include <fmt/format.h>

#include "app/force_table.hpp"
#include "app/verb.hpp"

namespace ferrule {
namespace {

struct Arguments {
  SceneArguments scene;
  std::string form, gap, length, depth, plot;
  double tilt_mrad = 0;
  bool json = false;
};

std::vector<double> lengths(const std::string& text, const std::string& option) {
  const std::vector<double> values = parse_range(text, option);
  for (const double v : values)
    if (v < 0) throw BadInput(option + " " + text + ": must not be negative");
  return values;
}

void print_table(const std::vector<ForceRow>& rows) {
  fmt::print("{:>9} {:>9} {:>8} {:>13} {:>13} {:>11} {:>9} {:>10} {:>10} {:>10}\n", "gap_nm",
             "length_um", "depth_nm", "van_der_Waals", "electrostatic", "capillary", "gravity",
             "adhesion", "wall", "friction");
  for (const ForceRow& r : rows)
    fmt::print(
        "{:9.4g} {:9.4g} {:>8} {:13.6g} {:13.6g} {:11.6g} {:9.5g} {:10.6g} {:10.6g} {:10.6g}\n",
        r.gap_nm, r.length_um, r.depth_nm ? fmt::format("{:.4g}", *r.depth_nm) : "-",
        1e6 * r.van_der_waals, 1e6 * r.electrostatic, 1e6 * r.capillary, 1e6 * r.gravity,
        1e6 * r.adhesion, 1e6 * r.wall, 1e6 * r.friction);
  fmt::print("forces in uN; attraction negative, friction a magnitude; \"-\": not in contact\n");
}

int forces_verb(const Arguments& a) {
  Scene scene = load_scene(a.scene.scene, a.scene.settings, Planning::none);  // nothing left out
  if (!a.form.empty()) {
    const std::string file = a.scene.scene + " with --form " + a.form;
    set_form(scene.document, a.form == "printed" ? Form::printed : Form::corrected, file);
    scene = parse_scene(scene.document, file);
  }
  const std::vector<double> depths =
      a.depth.empty() ? std::vector<double>{} : lengths(a.depth, "--depth-nm");
  // In contact the gap is closed, unless one is asked for.
  const std::string gap = !a.gap.empty() ? a.gap : depths.empty() ? "10" : "0";
  const std::vector<double> gaps = lengths(gap, "--gap-nm");
  const std::vector<double> inserted = lengths(a.length, "--length-um");

  const double tilt = 1e-3 * a.tilt_mrad;
  for (const double g : gaps)
    for (const double l : inserted)
      if (tilt > 0 && 1e-9 * g + 1e-6 * l * tilt >= 2 * scene.world.annulus.clearance())
        throw BadInput(fmt::format(
            "--tilt-mrad {:g}: over {:g} um the fibre would leave the bore; at most {:g} mrad fit",
            a.tilt_mrad, l, 1e3 * (2 * scene.world.annulus.clearance() - 1e-9 * g) / (1e-6 * l)));

  std::vector<ForceRow> rows;
  for (const double g : gaps)
    for (const double l : inserted) {
      if (depths.empty()) rows.push_back(force_row(scene.world, g, l, std::nullopt, tilt));
      for (const double d : depths) rows.push_back(force_row(scene.world, g, l, d, tilt));
    }

  if (!a.plot.empty()) {
    const int swept = (gaps.size() > 1) + (inserted.size() > 1) + (depths.size() > 1);
    if (swept != 1) throw BadInput("--plot needs exactly one range among gap, length and depth");
    const Sweep sweep = gaps.size() > 1       ? Sweep::gap
                        : inserted.size() > 1 ? Sweep::length
                                              : Sweep::depth;
    write_svg(a.plot, force_plot(rows, sweep, scene.name));
    fmt::print(stderr, "wrote {}\n", a.plot);
  }
  if (a.json) {
    Json list = Json::array();
    for (const ForceRow& row : rows) list.push_back(to_json(row));
    print_json({{"scene", scene.name}, {"rows", list}});
  } else {
    print_table(rows);
  }
  return kDone;
}

}  // namespace

void add_forces(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand("forces", "Force curves against gap, length and penetration");
  auto a = std::make_shared<Arguments>();
  a->scene.add_to(*verb, "paper");
  a->length = "100";
  verb->add_option("--form", a->form, "Form of all laws, instead of the scene's")
      ->check(CLI::IsMember({"printed", "corrected"}));
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
  verb->add_flag("--json", a->json, "One JSON document on stdout");
  verb->add_option("--plot", a->plot, "Draw the curves")->type_name("FILE.svg");
  verb->callback([a, &run] { run = [a] { return forces_verb(*a); }; });
}

}  // namespace ferrule
