// ferrule replay: a recorded episode again.
#include "capture/replay.hpp"

#include <fmt/format.h>

#include "app/demonstration_plot.hpp"
#include "app/verb.hpp"
#include "insertion/scene_scaling.hpp"

namespace ferrule {
namespace {

struct ReplayArguments {
  std::string file, plot;
  bool verify = false, json = false;
};

// What the first difference says of the recording, at length.
std::string verdict(const std::optional<Difference>& d, const Episode& episode) {
  const EpisodeInfo& info = episode.info;
  if (!d) return fmt::format("identical: {} rows, every bit", episode.rows.rows());
  std::string text =
      fmt::format("differs first at row {} (t = {:.3f} s): {} is {:.17g}, expected {:.17g}", d->row,
                  static_cast<double>(d->row) * info.period, d->column, d->recorded, d->expected);
  if (info.build != program_build() || info.version != program_version())
    text += fmt::format("; recorded by ferrule {} ({}), this is {} ({})", info.version, info.build,
                        program_version(), program_build());
  return text;
}

Json to_json(const Difference& d) {
  return {{"row", d.row}, {"column", d.column}, {"recorded", d.recorded}, {"expected", d.expected}};
}

// Some forty rows, at the tip's scale.
void print_rows(const Episode& episode, double motion) {
  fmt::print("{:>8} {:>10} {:>10} {:>10} {:>9} {:>9} {:>9} {:>10} {:>10} {:>10}\n", "t_s", "x_um",
             "y_um", "z_um", "vx_um_s", "vy_um_s", "vz_um_s", "Fx_uN", "Fy_uN", "Fz_uN");
  const Eigen::Index stride = std::max<Eigen::Index>(1, episode.rows.rows() / 40);
  for (Eigen::Index n = 0; n < episode.rows.rows(); n += stride) {
    const auto row = episode.rows.row(n);
    const auto um = [&](int column) { return 1e6 * row[column]; };
    fmt::print(
        "{:8.3f} {:10.4f} {:10.4f} {:10.4f} {:9.3f} {:9.3f} {:9.3f} {:10.4f} {:10.4f} {:10.4f}\n",
        row[kTime.begin], um(kStates.begin), um(kStates.begin + 1), um(kStates.begin + 2),
        um(kCommand.begin) / motion, um(kCommand.begin + 1) / motion,
        um(kCommand.begin + 2) / motion, um(kHolder.begin), um(kHolder.begin + 1),
        um(kHolder.begin + 2));
  }
}

int replay_verb(const ReplayArguments& a) {
  const Episode episode = read_episode(a.file);
  const EpisodeInfo& info = episode.info;
  const Eigen::Index rows = episode.rows.rows();
  const double time = rows ? episode.rows(rows - 1, kTime.begin) : 0.0;
  const Scene scene = recorded_scene(episode, a.file);
  if (!a.plot.empty()) write_plot(a.plot, demonstration_plot(episode, scene));
  std::optional<Difference> different;
  if (a.verify && !(different = verify(episode))) different = derived_difference(a.file, episode);
  if (a.json) {
    Json json = {{"file", a.file},
                 {"scene", scene.name},
                 {"operator", info.operator_},
                 {"outcome", name(info.outcome)},
                 {"rows", rows},
                 {"time_s", time},
                 {"version", info.version},
                 {"build", info.build}};
    if (a.verify) json["identical"] = !different.has_value();
    if (different) json["difference"] = to_json(*different);
    print_json(json);
  } else {
    fmt::print("{}: scene {}, {}, {}, {} rows, {:.2f} s\n", a.file, scene.name, info.operator_,
               name(info.outcome), rows, time);
    if (a.verify)
      fmt::print("{}\n", verdict(different, episode));
    else
      print_rows(episode, scene_scaling(scene).motion);
  }
  return different ? kFailed : kDone;
}

}  // namespace

void add_replay(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand("replay", "Play a recorded episode again");
  auto a = std::make_shared<ReplayArguments>();
  verb->add_option("episode", a->file, "Episode file")->required()->type_name("FILE.h5");
  verb->add_flag("--verify", a->verify,
                 "Drive the simulator from the recorded hand and compare bit for bit; exit code 1 "
                 "at a difference");
  verb->add_option("--plot", a->plot, "Draw velocity and forces over time")->type_name("FILE.svg");
  add_json(*verb, a->json);
  verb->callback([a, &run] { run = [a] { return replay_verb(*a); }; });
}

}  // namespace ferrule
