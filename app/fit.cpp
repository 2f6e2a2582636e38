// ferrule fit: a controller from demonstrations.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>

#include "app/fit_torch.hpp"
#include "app/law_plot.hpp"
#include "app/verb.hpp"
#include "controller/policy_file.hpp"
#include "learn/fit_law.hpp"

namespace ferrule {
namespace {

struct Arguments {
  std::string folder, method = "ceres", law = name(LawKind::insertion), out, plot;
  std::uint64_t seed = 1;
  FitTorch torch;
  bool json = false;
};

constexpr const char* kAuto = "auto";

std::vector<std::string> law_choices() {
  std::vector<std::string> choices = {kAuto};
  for (const LawKind kind : kLaws) choices.push_back(name(kind));
  return choices;
}

// Empty: to be chosen.
std::optional<LawKind> law_kind(const std::string& law) {
  for (const LawKind kind : kLaws)
    if (law == name(kind)) return kind;
  return std::nullopt;
}

void print_cross_validation(const ControllerFile& c) {
  fmt::print("{:<14} {:>5} {:>22} {:>16}\n", "law", "gains", "error, unseen [mm/s]",
             "standard error");
  for (const CrossValidated& law : c.cross_validation)
    fmt::print("{:<14} {:>5} {:>22.5g} {:>16.2g}{}\n", name(law.kind), gain_table(law.kind).size(),
               1e3 * law.error, 1e3 * law.standard_error, law.kind == c.kind ? "  chosen" : "");
}

// What could not be written after the fit is refused before it.
void expect_place_for(const std::string& file) {
  namespace fs = std::filesystem;
  std::error_code error;
  if (fs::is_directory(file, error)) throw FileTrouble(file + ": is a directory");
  const fs::path folder = fs::path(file).parent_path();
  if (!folder.empty() && !fs::is_directory(folder, error))
    throw FileTrouble(file + ": cannot be written: there is no folder " + folder.string());
}

int fit_verb(const Arguments& a) {
  expect_place_for(a.out);
  if (!a.plot.empty()) expect_place_for(a.plot);
  if (a.method == "torch") expect_place_for(weights_file(a.out));
  const DemonstrationSet set = load_demonstrations(a.folder);
  if (a.method == "torch") return fit_torch(set, a.folder, a.out, a.plot, a.seed, a.torch, a.json);
  FitReport report;
  try {
    report = fit_law(set, a.seed, law_kind(a.law));
  } catch (const BadInput& error) {
    throw BadInput(a.folder + ": " + error.what());
  }
  if (set.scenes.size() > 1)
    fmt::print(stderr, "note: the episodes are of {} different scenes: {}\n", set.scenes.size(),
               fmt::join(set.scenes, ", "));
  write_controller(a.out, report.controller);
  const ControllerFile& c = report.controller;
  if (!a.plot.empty()) {
    write_svg(a.plot, law_plot(set, c));
    fmt::print(stderr, "wrote {}\n", a.plot);
  }
  if (a.json) {
    print_json(parse_json(read_text(a.out), a.out));
    return kDone;
  }
  if (!c.cross_validation.empty()) print_cross_validation(c);
  fmt::print("law: {}\n", name(c.kind));
  fmt::print("{:<14} {:>14} {:>14} {:>14}  {}\n", "gain", "value", "95 % low", "95 % high", "unit");
  const auto table = gain_table(c.kind);
  for (std::size_t i = 0; i < table.size(); ++i) {
    const FittedGain& g = c.gains[i];
    const auto shown = [](double x) {
      return std::isfinite(x) ? fmt::format("{:.6g}", x) : std::string("open");
    };
    fmt::print("{:<14} {:>14.6g} {:>14} {:>14}  {}\n", table[i].name, g.value, shown(g.low),
               shown(g.high), table[i].unit);
  }
  fmt::print("reaction time {:.2f} s (identified, not imitated)\n", c.reaction_time);
  fmt::print("{} training episodes, {} held out, {} unsuccessful left out, {} rows\n",
             c.trained_on.episodes.size(), c.trained_on.held_out.size(), set.unsuccessful,
             c.trained_on.rows);
  fmt::print("velocity residual {:.4g} mm/s, held out {:.4g} mm/s (hand); {:.1f} % explained\n",
             1e3 * c.residual, 1e3 * c.held_out_residual, 100 * report.explained);
  fmt::print("{}\nwrote {}\n", report.summary, a.out);
  return kDone;
}

}  // namespace

void add_fit(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand("fit", "Fit a controller to demonstrations");
  auto a = std::make_shared<Arguments>();
  verb->add_option("folder", a->folder, "Folder with the episodes")->required()->type_name("DIR");
  verb->add_option("--method", a->method, "How")
      ->capture_default_str()
      ->check(CLI::IsMember({"ceres", "torch"}));
  verb->add_option("--law", a->law, "Which; auto: chosen by cross-validation over episodes")
      ->capture_default_str()
      ->check(CLI::IsMember(law_choices()));
  verb->add_option("--plot", a->plot, "The law over the data; with torch: the training curve")
      ->type_name("FILE.svg");
  verb->add_option("--out", a->out, "Controller file")->required()->type_name("FILE.json");
  add_seed(*verb, a->seed, "Seed of the split into training and held-out episodes");
  add_fit_torch(*verb, a->torch);
  verb->add_flag("--json", a->json, "The controller file on stdout as well");
  verb->callback([a, verb, &run] {
    if (a->method != "torch") refuse_fit_torch(*verb);
    if (a->method == "torch" && verb->count("--law") > 0)
      throw CLI::ValidationError("--law", "needs --method ceres");
    run = [a] { return fit_verb(*a); };
  });
}

}  // namespace ferrule
