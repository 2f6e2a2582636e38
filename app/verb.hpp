// What the verbs share: how they are added to the program, their scene arguments, their output.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

#include "app/interrupt.hpp"
#include "app/progress.hpp"
#include "app/provenance.hpp"
#include "insertion/operator_skill.hpp"

namespace ferrule {

// Exit codes (README): 0 done, 1 a stated criterion failed, 2 bad usage or input, 3 file trouble,
// 4 device trouble, 130 stopped by Ctrl-C or another signal, 141 (as by SIGPIPE) stopped because
// nobody reads standard output any more.
enum ExitCode {
  kDone = 0,
  kFailed = 1,
  kBadInput = 2,
  kFileTrouble = 3,
  kDeviceTrouble = 4,
  kInterrupted = 130,
  kNobodyReads = 141
};

// What the chosen verb does; set when the command line is parsed.
using Run = std::function<int()>;

void add_scene(CLI::App& app, Run& run);
void add_forces(CLI::App& app, Run& run);
void add_contact(CLI::App& app, Run& run);
void add_release(CLI::App& app, Run& run);
void add_limits(CLI::App& app, Run& run);
void add_plan(CLI::App& app, Run& run);
void add_record(CLI::App& app, Run& run);
void add_compare(CLI::App& app, Run& run);
void add_bench(CLI::App& app, Run& run);
void add_recover(CLI::App& app, Run& run);
void add_import(CLI::App& app, Run& run);
void add_replay(CLI::App& app, Run& run);
void add_fit(CLI::App& app, Run& run);
void add_identify(CLI::App& app, Run& run);
void add_improve(CLI::App& app, Run& run);
void add_merge(CLI::App& app, Run& run);
void add_submit(CLI::App& app, Run& run);
void add_evaluate(CLI::App& app, Run& run);
void add_sweep(CLI::App& app, Run& run);
void add_map(CLI::App& app, Run& run);
void add_sensitivity(CLI::App& app, Run& run);
void add_report(CLI::App& app, Run& run);
void add_score(CLI::App& app, Run& run);
void add_export(CLI::App& app, Run& run);
void add_export_episodes(CLI::App& app, Run& run);
void add_demo(CLI::App& app, Run& run);
void add_view(CLI::App& app, Run& run);
void add_devices(CLI::App& app, Run& run);
void add_doctor(CLI::App& app, Run& run);

// Does what a command line says, of which `words` are all but the program's name; its exit code.
// Throws what the verb throws. (main.cpp)
int run_command(const std::vector<std::string>& words);

// --scene NAME|FILE and --set dotted.key=value. One rule for all verbs: a controller or a recording
// brings its scene along, --scene takes another, and where there is neither it is `demo`.
struct SceneArguments {
  std::string scene;  // empty: not given
  std::vector<std::string> settings;

  // `unless_given`: which one it is then, for the help.
  void add_to(CLI::App& verb, const std::string& unless_given = "demo");
  std::string name() const { return scene.empty() ? "demo" : scene; }
  // As they were given, for a command that is shown: each after a space.
  std::string given() const;
  // What --scene and --set say alone, not planned. Throws BadInput, FileTrouble.
  Scene load() const;
  // Throws BadInput, FileTrouble.
  ChosenScene choose(const BroughtScene& brought = {}) const;
};

// --plot of a verb that draws one: SVG, and a file that says to be of another kind is refused.
void add_plot(CLI::App& verb, std::string& file, const std::string& help);
// A whole number from 0 to 2^63 - 1, the rule of every seed.
CLI::Validator seed_rule();
// --seed, or another flag: a whole number from 0 to 2^63 - 1.
void add_seed(CLI::App& verb, std::uint64_t& seed, const std::string& help,
              const char* flag = "--seed");
// --skill of a simulated operator (insertion/operator_skill.hpp).
CLI::Option* add_skill(CLI::App& verb, OperatorSkill& skill, const std::string& help);
// --seeds: "1..5" or "1,2,7".
void add_seeds(CLI::App& verb, std::string& seeds, const std::string& help);
// Throws BadInput.
std::vector<std::uint64_t> parse_seeds(const std::string& text);

// --threads of a campaign. 0: all cores.
void add_threads(CLI::App& verb, int& threads);
// At the end of --help; without "ferrule".
void add_examples(CLI::App& verb, const std::vector<std::string>& examples);
// --json, for what ends in print_json.
void add_json(CLI::App& verb, bool& json);

// --json or --csv instead of text, for what ends in print_result.
struct Output {
  bool json = false, csv = false;
  bool text() const { return !json && !csv; }
};
void add_output(CLI::App& verb, Output& output);
// Prints `document` with its provenance, or as CSV the rows that it holds at `table`; nothing as
// text.
void print_result(const Output& output, Json document, const char* table,
                  const Provenance& provenance);

// `scene`, or where it states an accuracy the planned one, with progress. Throws Stopped.
Scene planned_with_progress(const Scene& scene);

// One of these texts; of another one it names the nearest.
CLI::Validator one_of(const std::vector<std::string>& choices);
// A whole number within bounds, in decimal.
CLI::Validator whole_number(std::uint64_t low, std::uint64_t high);
// A finite number within bounds, in decimal.
CLI::Validator number_between(double low, double high);

// The one JSON document of --json, on stdout.
void print_json(const Json& json);
void print_json(Json json, const Provenance& provenance);
// An array of it: `of(row)` for each of `rows`.
template <class Rows, class Of>
Json json_list(const Rows& rows, const Of& of) {
  Json list = Json::array();
  for (const auto& row : rows) list.push_back(of(row));
  return list;
}

// `x` as `format` of fmt says, or `otherwise` where it is not finite.
std::string number_or(const char* otherwise, const char* format, double x);

// What could not be written after long work is refused before it. Empty: nothing is to be written.
// Throws FileTrouble.
void expect_place_for(const std::string& file);

// "10", "1:500:50" (from:to:count, both ends in), "1:500:50:log". Throws BadInput naming `option`.
std::vector<double> parse_range(const std::string& text, const std::string& option);

// That part of the way, 0 to 1, between two ends; `logarithmic`: in equal ratios, both ends > 0.
double interpolate(double from, double to, double part, bool logarithmic);

}  // namespace ferrule
