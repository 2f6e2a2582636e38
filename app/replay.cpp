// ferrule replay: a recorded episode again.
#include "capture/replay.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cmath>
#include <filesystem>

#include "app/demonstration_plot.hpp"
#include "app/interrupt.hpp"
#include "app/output.hpp"
#include "app/progress.hpp"
#include "app/validators.hpp"
#include "app/verbs.hpp"
#include "insertion/scene_scaling.hpp"

namespace ferrule {
namespace {

// What only inputs_sha1 covers.
constexpr const char* kNotCovered[] = {"operator", "build",   "version",  "why",        "rating",
                                       "loop",     "mapping", "coupling", "raw counts", "phases"};

struct ReplayArguments {
  std::string path, plot;
  double tolerance = 0;
  bool verify = false;
  std::string trace;  // the time of a step [s], or kCostliest
  Output output;
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
std::string verdict(const Verification& c, const EpisodeRows& episode) {
  const EpisodeInfo& info = episode.info();
  std::string text;
  if (c.first)
    text = "differs first at " + told(*c.first, info.period);
  else if (c.largest)
    text = fmt::format("within {:g}: {} rows, and all that is beside them", c.tolerance,
                       episode.count());
  else
    text =
        fmt::format("identical: {} rows, every bit, and all that is beside them", episode.count());
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

constexpr std::array<const char*, 10> kRowNames = {
    "t_s", "x_um", "y_um", "z_um", "vx_um_s", "vy_um_s", "vz_um_s", "Fx_uN", "Fy_uN", "Fz_uN"};

// Row n at the tip's scale, in the order of the names.
std::array<double, kRowNames.size()> row_of(const EpisodeRows& episode, Eigen::Index n,
                                            double motion) {
  const auto row = episode.row(n);
  const auto um = [&](int column) { return 1e6 * row[column]; };
  return {row[kTime.begin],
          um(state_column("tip_x")),
          um(state_column("tip_y")),
          um(state_column("tip_z")),
          um(kCommand.begin) / motion,
          um(kCommand.begin + 1) / motion,
          um(kCommand.begin + 2) / motion,
          um(kHolder.begin),
          um(kHolder.begin + 1),
          um(kHolder.begin + 2)};
}

// Some forty rows.
void print_rows(const EpisodeRows& episode, double motion) {
  for (const char* name : kRowNames) fmt::print(" {:>11}", name);
  fmt::print("\n");
  const Eigen::Index stride = std::max<Eigen::Index>(1, episode.count() / 40);
  for (Eigen::Index n = 0; n < episode.count(); n += stride) {
    for (const double x : row_of(episode, n, motion)) fmt::print(" {:>11.6g}", x);
    fmt::print("\n");
  }
}

// All of them.
Json rows_json(const EpisodeRows& episode, double motion) {
  Json list = Json::array();
  for (Eigen::Index n = 0; n < episode.count(); ++n) {
    Json& row = list.emplace_back();
    const auto values = row_of(episode, n, motion);
    for (std::size_t i = 0; i < values.size(); ++i) row[kRowNames[i]] = values[i];
  }
  return list;
}

// One recording, and what verifying it found.
struct Replayed {
  std::string file;
  EpisodeRows episode;
  Scene scene;
  double time = 0;      // that the task took, as record and score say it [s]
  double recorded = 0;  // to the end [s]
  Verification compared{};
};

// The time of the task until the success depth was reached, or else to the end.
void take_times(Replayed& r) {
  bool reached = false;
  for (Eigen::Index n = 0; n < r.episode.count(); ++n) {
    const auto row = r.episode.row(n);
    r.recorded = row[state_column("time")];
    if (!reached) r.time = r.recorded;
    reached |= -row[state_column("tip_x")] >= r.scene.success.depth;
  }
}

Replayed replayed(const ReplayArguments& a, const std::string& file) {
  const EpisodeRows episode = open_episode(file);
  Replayed r{file, episode, recorded_scene(episode.info(), file)};
  r.compared.tolerance = a.tolerance;
  take_times(r);
  if (a.verify) verify(r.episode, r.compared);
  if (a.verify && !r.compared.over()) compare_file(file, r.compared);
  return r;
}

Json to_json(const ReplayArguments& a, const Replayed& r) {
  const EpisodeInfo& info = r.episode.info();
  Json json = {{"file", r.file},
               {"scene", r.scene.name},
               {"operator", info.operator_},
               {"seed", info.seed},
               {"trial", info.trial},
               {"outcome", name(info.outcome)},
               {"rows", r.episode.count()},
               {"time_s", r.time},
               {"recorded_s", r.recorded},
               {"version", info.version},
               {"build", info.build}};
  const Verification& compared = r.compared;
  if (a.verify) {
    json["identical"] = !compared.first && !compared.largest;
    json["tolerance"] = a.tolerance;
    json["within_tolerance"] = !compared.first;
    json["not_covered"] = info.inputs_sha1.empty() ? Json(kNotCovered) : Json::array();
  }
  if (compared.first) json["difference"] = to_json(*compared.first);
  if (compared.largest) json["largest_difference"] = to_json(*compared.largest);
  return json;
}

void print(const ReplayArguments& a, const Replayed& r) {
  const EpisodeInfo& info = r.episode.info();
  fmt::print("{}: scene {}, {}, {}, {} rows, {:.2f} s of {:.2f} s\n", printable(r.file),
             printable(r.scene.name, 60), printable(info.operator_, 100), name(info.outcome),
             r.episode.count(), r.time, r.recorded);
  if (a.verify) fmt::print("{}\n", verdict(r.compared, r.episode));
}

constexpr std::array<const char*, 4> kStatusNames = {"ok", "not converged", "bad command",
                                                     "iteration limit"};

constexpr const char* kCostliest = "costliest";

TracedStep traced_step(const EpisodeRows& episode, const std::string& which) {
  if (which == kCostliest) return trace_step(episode, std::nullopt);
  double time = 0;
  if (!CLI::detail::lexical_cast(which, time))
    throw BadInput("--trace " + printable(which, 40) + ": expected a time [s], or " + kCostliest);
  const double period = episode.info().period;
  const Eigen::Index last = episode.count() - 1;
  if (!(time >= 0 && time <= (static_cast<double>(last) + 0.5) * period))
    throw BadInput(fmt::format("--trace {:g}: the episode ends at {:.3f} s", time,
                               static_cast<double>(last) * period));
  return trace_step(episode, std::min<Eigen::Index>(last, std::lround(time / period)));
}

Json trace_json(const TracedStep& traced) {
  Json entries = Json::array();
  for (const TraceEntry& e : traced.trace.entries())
    entries.push_back({{"part", e.part},
                       {"stage", kStageNames[static_cast<std::size_t>(e.stage)]},
                       {"decision", e.decision},
                       {"evaluations", e.evaluations},
                       {"residual", number_or_null(e.residual)},
                       {"move_clearances", number_or_null(e.move)}});
  const StepResult& r = traced.result;
  return {{"from_s", traced.before.time},
          {"to_s", r.state.time},
          {"status", kStatusNames[static_cast<std::size_t>(r.status)]},
          {"evaluations", r.evaluations},
          {"substeps", r.substeps},
          {"rejected", r.rejected},
          {"stages", entries}};
}

void print_trace(const TracedStep& traced) {
  const StepResult& r = traced.result;
  const auto figure = [](double x) {
    return std::isfinite(x) ? fmt::format("{:.2g}", x) : std::string("-");
  };
  fmt::print(
      "step from {:.4f} s to {:.4f} s: {}; {} evaluations, {} sub-steps accepted, {} "
      "rejected\n\n{:>9} {:<13} {:>5} {:>9} {:>9}  {}\n",
      traced.before.time, r.state.time, kStatusNames[static_cast<std::size_t>(r.status)],
      r.evaluations, r.substeps, r.rejected, "part", "stage", "eval", "residual", "move",
      "decision");
  for (const TraceEntry& e : traced.trace.entries())
    fmt::print("{:>9.6f} {:<13} {:>5} {:>9} {:>9}  {}\n", e.part,
               kStageNames[static_cast<std::size_t>(e.stage)], e.evaluations, figure(e.residual),
               figure(e.move), e.decision);
  fmt::print(
      "\npart: of the command's path, where the sub-step ends; eval: evaluations of the "
      "potential in the sub-step so far; residual: over the sum of all forces; move: of the "
      "end, over the clearance\n");
}

// All episodes of a folder, one line each.
int replay_folder(const ReplayArguments& a) {
  if (!a.trace.empty()) throw BadInput("--trace: traces one episode; " + a.path + " is a folder");
  if (!a.plot.empty()) throw BadInput("--plot: draws one episode; " + a.path + " is a folder");
  Provenance provenance;
  Json list = Json::array();
  std::size_t different = 0;
  const std::vector<std::string> files = episode_files(a.path);
  if (files.empty()) throw BadInput(a.path + ": no episodes in it");
  Progress progress("replaying", files.size());
  for (const std::string& file : files) {
    if (interrupted()) break;
    const Replayed r = replayed(a, file);
    provenance.read(file);
    list.push_back(to_json(a, r));
    different += r.compared.first.has_value();
    progress(list.size());
    if (a.output.text()) print(a, r);
  }
  if (interrupted())
    provenance.partial(fmt::format("{} of {} episodes", list.size(), files.size()));
  if (a.output.text()) fmt::print("{}", provenance.foot());
  print_result(a.output, {{"folder", a.path}, {"episodes", list}}, "episodes", provenance);
  return interrupted() ? kInterrupted : different ? kFailed : kDone;
}

int replay_file(const ReplayArguments& a) {
  const Replayed r = replayed(a, a.path);
  std::optional<TracedStep> traced;
  if (!a.trace.empty()) traced = traced_step(r.episode, a.trace);
  if (!a.plot.empty()) write_plot(a.plot, demonstration_plot(read_episode(a.path), r.scene));
  Provenance provenance;
  provenance.in({r.scene, "", ", as recorded"}).seed("start and operator", r.episode.info().seed);
  provenance.read(a.path);
  if (a.output.text()) {
    fmt::print("{}", provenance.head());
    print(a, r);
    if (traced)
      print_trace(*traced);
    else if (!a.verify)
      print_rows(r.episode, scene_scaling(r.scene).motion);
    fmt::print("{}", provenance.foot());
  }
  Json json = to_json(a, r);
  if (traced) json["trace"] = trace_json(*traced);
  if (a.output.csv) json["table"] = rows_json(r.episode, scene_scaling(r.scene).motion);
  print_result(a.output, json, "table", provenance);
  return r.compared.first ? kFailed : kDone;
}

int replay_verb(const ReplayArguments& a) {
  std::error_code error;
  return std::filesystem::is_directory(a.path, error) ? replay_folder(a) : replay_file(a);
}

}  // namespace

void add_replay(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand("replay", "Play a recorded episode again");
  auto a = std::make_shared<ReplayArguments>();
  verb->add_option("episode", a->path, "Episode file, or a folder of them")
      ->required()
      ->type_name("FILE.h5|DIR");
  auto* verify = verb->add_flag(
      "--verify", a->verify,
      "Drive the simulator from the recorded hand and compare bit for bit; exit code 1 "
      "at a difference");
  verb->add_option("--tolerance", a->tolerance,
                   "How far numbers may be apart, of the largest of their unit: for recordings of "
                   "another build or compiler")
      ->needs(verify)
      ->check(number_between(0, 1));
  verb->add_option(
          "--trace", a->trace,
          "Take the step that ends at this time again, or the one with the most evaluations, "
          "and print what each stage of the solver decided in it, and why")
      ->type_name("SECONDS|costliest");
  add_plot(*verb, a->plot, "Draw velocity and forces over time");
  add_output(*verb, a->output);
  add_examples(*verb,
               {"replay episodes/episode_0001.h5 --plot episode.svg", "replay episodes --verify",
                "replay episodes/episode_0001.h5 --trace costliest"});
  verb->callback([a, &run] { run.verb = [a] { return replay_verb(*a); }; });
}

}  // namespace ferrule
