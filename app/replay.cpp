// ferrule replay: a recorded episode again.
#include "capture/replay.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "app/demonstration_plot.hpp"
#include "app/verb.hpp"
#include "insertion/scene_scaling.hpp"

namespace ferrule {
namespace {

// What only inputs_sha1 covers.
constexpr const char* kNotCovered[] = {"operator", "build",   "version",  "why",       "rating",
                                       "loop",     "mapping", "coupling", "raw counts"};

struct ReplayArguments {
  std::string file, plot;
  double tolerance = 0;
  bool verify = false, json = false;
};

std::string told(const Difference& d, double period) {
  const auto text = [](const Json& value) {
    return value.is_null() ? std::string("not there")
           : value.is_number_float()
               ? fmt::format("{:.17g}", value.get<double>())
               : printable(value.dump(-1, ' ', false, Json::error_handler_t::replace), 100);
  };
  return fmt::format("row {} (t = {:.3f} s): {} is {}, expected {}", d.row,
                     static_cast<double>(d.row) * period, printable(d.column, 200),
                     text(d.recorded), text(d.expected));
}

std::string makers(const EpisodeInfo& info) {
  return fmt::format("recorded by ferrule {} ({}), this is {} ({})", printable(info.version, 40),
                     printable(info.build, 80), program_version(), program_build());
}

// What the comparison says of the recording, at length.
std::string verdict(const Verification& c, const Episode& episode) {
  const EpisodeInfo& info = episode.info;
  std::string text;
  if (c.first)
    text = "differs first at " + told(*c.first, info.period);
  else if (c.largest)
    text = fmt::format("within {:g}: {} rows, and all that is beside them", c.tolerance,
                       episode.rows.rows());
  else
    text = fmt::format("identical: {} rows, every bit, and all that is beside them",
                       episode.rows.rows());
  if (c.tolerance > 0 && c.largest)
    text += fmt::format("; the largest difference is {:.2g} of the largest number, at {}",
                        c.largest->relative, told(*c.largest, info.period));
  if (info.inputs_sha1.empty())
    text += fmt::format("; not covered, as the recording has no hash of them: {}",
                        fmt::join(kNotCovered, ", "));
  if (c.first || c.largest) text += "; " + makers(info);
  return text;
}

Json to_json(const Difference& d) {
  return {{"row", d.row},
          {"column", d.column},
          {"recorded", d.recorded},
          {"expected", d.expected},
          {"relative", number_or_null(d.relative)}};
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
  Verification compared{a.tolerance, {}, {}};
  if (a.verify) verify(episode, compared);
  if (a.verify && !compared.over()) compare_file(a.file, episode, compared);
  if (a.json) {
    Json json = {{"file", a.file},
                 {"scene", scene.name},
                 {"operator", info.operator_},
                 {"outcome", name(info.outcome)},
                 {"rows", rows},
                 {"time_s", time},
                 {"version", info.version},
                 {"build", info.build}};
    if (a.verify) {
      json["identical"] = !compared.first && !compared.largest;
      json["tolerance"] = a.tolerance;
      json["within_tolerance"] = !compared.first;
      json["not_covered"] = info.inputs_sha1.empty() ? Json(kNotCovered) : Json::array();
    }
    if (compared.first) json["difference"] = to_json(*compared.first);
    if (compared.largest) json["largest_difference"] = to_json(*compared.largest);
    print_json(json);
  } else {
    fmt::print("{}: scene {}, {}, {}, {} rows, {:.2f} s\n", a.file, printable(scene.name, 60),
               printable(info.operator_, 100), name(info.outcome), rows, time);
    if (a.verify)
      fmt::print("{}\n", verdict(compared, episode));
    else
      print_rows(episode, scene_scaling(scene).motion);
  }
  return compared.first ? kFailed : kDone;
}

}  // namespace

void add_replay(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand("replay", "Play a recorded episode again");
  auto a = std::make_shared<ReplayArguments>();
  verb->add_option("episode", a->file, "Episode file")->required()->type_name("FILE.h5");
  auto* verify = verb->add_flag(
      "--verify", a->verify,
      "Drive the simulator from the recorded hand and compare bit for bit; exit code 1 "
      "at a difference");
  verb->add_option("--tolerance", a->tolerance,
                   "How far numbers may be apart, of the largest of their unit: for recordings of "
                   "another build or compiler")
      ->needs(verify)
      ->check(number_between(0, 1));
  verb->add_option("--plot", a->plot, "Draw velocity and forces over time")->type_name("FILE.svg");
  add_json(*verb, a->json);
  verb->callback([a, &run] { run = [a] { return replay_verb(*a); }; });
}

}  // namespace ferrule
