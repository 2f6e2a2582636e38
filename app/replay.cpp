// ferrule replay: a recorded episode again.
#include "capture/replay.hpp"

#include <fmt/format.h>

#include "app/demonstration_plot.hpp"
#include "app/verb.hpp"
#include "insertion/scene_scaling.hpp"

namespace ferrule {
namespace {

struct Arguments {
  std::string file, plot;
  bool verify = false, json = false;
};

int replay_verb(const Arguments& a) {
  const Episode episode = read_episode(a.file);
  const EpisodeInfo& info = episode.info;
  const auto rows = static_cast<std::size_t>(episode.rows.rows());
  const Scene scene = parse_scene(parse_json(info.scene, a.file), a.file);
  if (!a.plot.empty()) {
    write_svg(a.plot, demonstration_plot(episode, scene));
    fmt::print(stderr, "wrote {}\n", a.plot);
  }
  Json json = {{"file", a.file},
               {"scene", scene.name},
               {"operator", info.operator_},
               {"outcome", name(info.outcome)},
               {"rows", rows},
               {"time_s", rows ? episode.rows(episode.rows.rows() - 1, kTime.begin) : 0.0},
               {"version", info.version},
               {"build", info.build}};
  int code = kDone;
  std::string verdict;
  if (a.verify) {
    std::optional<Difference> d = verify(episode);
    if (!d) d = derived_difference(a.file, episode);
    json["identical"] = !d.has_value();
    verdict = fmt::format("identical: {} rows, every bit", rows);
    if (d) {
      code = kFailed;
      json["difference"] = {{"row", d->row},
                            {"column", d->column},
                            {"recorded", d->recorded},
                            {"expected", d->expected}};
      verdict = fmt::format(
          "differs first at row {} (t = {:.3f} s): {} is {:.17g}, expected {:.17g}", d->row,
          static_cast<double>(d->row) * info.period, d->column, d->recorded, d->expected);
      if (info.build != program_build() || info.version != program_version())
        verdict += fmt::format("; recorded by ferrule {} ({}), this is {} ({})", info.version,
                               info.build, program_version(), program_build());
    }
  }
  if (a.json) {
    print_json(json);
    return code;
  }
  fmt::print("{}: scene {}, {}, {}, {} rows, {:.2f} s\n", a.file, json["scene"].get<std::string>(),
             info.operator_, name(info.outcome), rows, json["time_s"].get<double>());
  if (a.verify) {
    fmt::print("{}\n", verdict);
    return code;
  }
  fmt::print("{:>8} {:>10} {:>10} {:>10} {:>9} {:>9} {:>9} {:>10} {:>10} {:>10}\n", "t_s", "x_um",
             "y_um", "z_um", "vx_um_s", "vy_um_s", "vz_um_s", "Fx_uN", "Fy_uN", "Fz_uN");
  const double motion = scene_scaling(scene).motion;
  const std::size_t stride = std::max<std::size_t>(1, rows / 40);
  for (std::size_t n = 0; n < rows; n += stride) {
    const auto row = episode.rows.row(static_cast<Eigen::Index>(n));
    const auto um = [&](int column) { return 1e6 * row[column]; };
    fmt::print(
        "{:8.3f} {:10.4f} {:10.4f} {:10.4f} {:9.3f} {:9.3f} {:9.3f} {:10.4f} {:10.4f} {:10.4f}\n",
        row[kTime.begin], um(kStates.begin), um(kStates.begin + 1), um(kStates.begin + 2),
        um(kCommand.begin) / motion, um(kCommand.begin + 1) / motion,
        um(kCommand.begin + 2) / motion, um(kHolder.begin), um(kHolder.begin + 1),
        um(kHolder.begin + 2));
  }
  return code;
}

}  // namespace

void add_replay(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand("replay", "Play a recorded episode again");
  auto a = std::make_shared<Arguments>();
  verb->add_option("episode", a->file, "Episode file")->required()->type_name("FILE.h5");
  verb->add_flag("--verify", a->verify,
                 "Drive the simulator from the recorded hand and compare bit for bit; exit code 1 "
                 "at a difference");
  verb->add_option("--plot", a->plot, "Draw velocity and forces over time")->type_name("FILE.svg");
  verb->add_flag("--json", a->json, "One JSON document on stdout");
  verb->callback([a, &run] { run = [a] { return replay_verb(*a); }; });
}

}  // namespace ferrule
