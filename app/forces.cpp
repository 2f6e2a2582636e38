// ferrule forces: force curves against gap, inserted length and penetration.
#include <fmt/format.h>

#include "app/force_table.hpp"
#include "app/verb.hpp"

namespace ferrule {
namespace {

struct Arguments {
  SceneArguments scene;
  std::string form, gap, length, depth, plot;
  double tilt_mrad = 0, speed_um_s = 10;
  bool json = false;
};

std::vector<double> lengths(const std::string& text, const std::string& option) {
  const std::vector<double> values = parse_range(text, option);
  for (const double v : values)
    if (v < 0) throw BadInput(option + " " + text + ": must not be negative");
  return values;
}

void print_table(const std::vector<ForceRow>& rows, bool liquid) {
  fmt::print("{:>9} {:>9} {:>8} {:>13} {:>13} {:>11} {:>9} {:>10} {:>10} {:>10}", "gap_nm",
             "length_um", "depth_nm", "van_der_Waals", "electrostatic", "capillary", "gravity",
             "adhesion", "wall", "friction");
  if (liquid) fmt::print(" {:>10} {:>10} {:>10}", "meniscus", "drag", "squeeze");
  fmt::print("\n");
  for (const ForceRow& r : rows) {
    fmt::print(
        "{:9.4g} {:9.4g} {:>8} {:13.6g} {:13.6g} {:11.6g} {:9.5g} {:10.6g} {:10.6g} {:10.6g}",
        r.gap_nm, r.length_um, r.depth_nm ? fmt::format("{:.4g}", *r.depth_nm) : "-",
        1e6 * r.van_der_waals, 1e6 * r.electrostatic, 1e6 * r.capillary, 1e6 * r.gravity,
        1e6 * r.adhesion, 1e6 * r.wall, 1e6 * r.friction);
    if (liquid)
      fmt::print(" {:10.6g} {:10.6g} {:10.6g}", 1e6 * r.meniscus, 1e6 * r.drag, 1e6 * r.squeeze);
    fmt::print("\n");
  }
  fmt::print("forces in uN; attraction negative, friction{} {}; \"-\": not in contact\n",
             liquid ? ", meniscus and drag" : "", liquid ? "magnitudes" : "a magnitude");
}

// The gap is the smallest where that at the middle does not exceed the clearance. Only printed laws
// know no other wall.
void check_fits(const World& world, double gap_nm, double length_um, double tilt_mrad) {
  const auto corrected = [](const auto& law) { return law && law->form == Form::corrected; };
  const bool walls = corrected(world.laws.van_der_waals) || corrected(world.laws.electrostatic) ||
                     corrected(world.laws.capillary) || world.laws.drag;
  const double clearance = 1e9 * world.annulus.clearance(), slack = 1e-9 * clearance;
  if (!walls && tilt_mrad == 0) return;
  if (gap_nm > clearance + slack)
    throw BadInput(fmt::format("--gap-nm {:g}: the smallest gap is at most the clearance, {:g} nm",
                               gap_nm, clearance));
  if (gap_nm + 0.5 * length_um * tilt_mrad > clearance + slack)
    throw BadInput(
        fmt::format("--tilt-mrad {:g}: over {:g} um a gap of {:g} nm would not be the smallest; "
                    "at most {:g} mrad fit",
                    tilt_mrad, length_um, gap_nm, 2 * (clearance - gap_nm) / length_um));
}

int forces_verb(const Arguments& a) {
  // Nothing is left out. The settings are those of the form asked for.
  const bool own_form = a.form.empty();
  Scene scene = load_scene(a.scene.scene, own_form ? a.scene.settings : std::vector<std::string>{});
  if (!own_form) {
    for (const std::string& setting : a.scene.settings) apply_setting(scene.document, setting);
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

  for (const double g : gaps)
    for (const double l : inserted) check_fits(scene.world, g, l, a.tilt_mrad);

  const Lie lie{1e-3 * a.tilt_mrad, 1e-6 * a.speed_um_s};
  std::vector<ForceRow> rows;
  for (const double g : gaps)
    for (const double l : inserted) {
      if (depths.empty()) rows.push_back(force_row(scene.world, g, l, std::nullopt, lie));
      for (const double d : depths) rows.push_back(force_row(scene.world, g, l, d, lie));
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
    print_table(rows, scene.world.laws.meniscus || scene.world.laws.drag);
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
  verb->add_option("--speed-um-s", a->speed_um_s,
                   "Speed that drag is given for: along the bore, and towards the wall (squeeze)")
      ->capture_default_str()
      ->check(number_between(0, 1e9));
  verb->add_flag("--json", a->json, "One JSON document on stdout");
  verb->add_option("--plot", a->plot, "Draw the curves")->type_name("FILE.svg");
  verb->callback([a, &run] { run = [a] { return forces_verb(*a); }; });
}

}  // namespace ferrule
