// ferrule import: episodes of what a page that runs without the program has saved.
#include <fmt/format.h>

#include "app/interrupt.hpp"
#include "app/output.hpp"
#include "app/verbs.hpp"
#include "capture/recorder.hpp"
#include "sim/base/content_hash.hpp"
#include "sim/base/json_file.hpp"
#include "view/input_log.hpp"

namespace ferrule {
namespace {

struct ImportArguments {
  std::vector<std::string> files;
  std::string out;
  Output output;
};

EpisodeInfo info_of(const InputLog& log, const Scene& scene, const Device& hand) {
  EpisodeInfo info = episode_info(scene, hand, log.info.seed, log.info.trial);
  info.operator_ = log.info.operator_;
  info.trainee = log.info.trainee;
  info.date = log.info.date;
  info.session = log.info.session;
  info.why = log.info.why;
  return info;
}

// One episode: a line of the result. Throws BadInput, FileTrouble, Stopped.
Json import_log(const std::string& file, const std::string& folder) {
  const InputLog log =
      read_json(file, [&](const Json& json) { return parse_input_log(json, file); });
  const Scene scene = recorded_scene(log.info, file + ": scene");
  const TrialSetup trial = recorded_setup(log.info, scene);
  const std::unique_ptr<Device> hand = logged_hand(log, trial);
  Recorder recorder(folder, next_episode_number(folder), info_of(log, scene, *hand));
  Sha1 hash;
  const InsertionEnd end = run_insertion(trial, *hand, {}, [&](const Tick& tick) {
    const RowVector row = make_row(tick);
    hash.add(row.data(), sizeof(double) * static_cast<std::size_t>(row.size()));
    recorder.add(row, tick.sample.counts);
    return !interrupted();
  });
  const bool same = hash.text() == log.rows_sha1 && end.outcome == log.info.outcome;
  if (interrupted() || !same) recorder.discard();
  end_if_interrupted();
  if (!same)
    throw FileTrouble(fmt::format(
        "{}: computed again its rows are not those that were recorded: {} rows, {}, for {} rows, "
        "{}; recorded by ferrule {} ({}), this is {} ({})",
        file, recorder.rows(), name(end.outcome), log.rows(), name(log.info.outcome),
        printable(log.info.version, 40), printable(log.info.build, 80), program_version(),
        program_build()));
  return {{"log", file},
          {"file", recorder.finish(end.outcome)},
          {"rows", recorder.rows()},
          {"outcome", name(end.outcome)}};
}

int import_verb(const ImportArguments& a) {
  Provenance provenance;
  Json list = Json::array();
  for (const std::string& file : a.files) {
    provenance.read(file);
    list.push_back(import_log(file, a.out));
    const Json& row = list.back();
    if (a.output.text())
      fmt::print("{} -> {}: {} rows, outcome {}\n", printable(file),
                 printable(row["file"].get<std::string>()), row["rows"].get<std::size_t>(),
                 row["outcome"].get<std::string>());
  }
  if (a.output.text()) fmt::print("{}", provenance.foot());
  print_result(a.output, {{"imported", list}}, "imported", provenance);
  return kDone;
}

}  // namespace

void add_import(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand("import", "Episodes of what the page without a program saved");
  auto a = std::make_shared<ImportArguments>();
  verb->add_option("files", a->files, "Saved tries")->required()->type_name("FILE...");
  verb->add_option("--out", a->out, "Folder for the episodes; made if it is not there")
      ->required()
      ->type_name("DIR");
  add_output(*verb, a->output);
  add_examples(*verb,
               {"import try_0001.json --out episodes", "import try_*.json --out episodes --json"});
  verb->callback([a, &run] { run.verb = [a] { return import_verb(*a); }; });
}

}  // namespace ferrule
