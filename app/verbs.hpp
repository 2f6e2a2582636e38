// The verbs of the program: how each is added to it, and how it ends.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

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

struct SharedJob;  // app/shards.hpp

struct Run {
  // What the chosen verb does, and its exit code; set when the command line is parsed.
  std::function<int()> verb;
  SharedJob& job;  // for its trials
};

void add_scene(CLI::App& app, Run& run);
void add_forces(CLI::App& app, Run& run);
void add_contact(CLI::App& app, Run& run);
void add_release(CLI::App& app, Run& run);
void add_limits(CLI::App& app, Run& run);
void add_plan(CLI::App& app, Run& run);
void add_record(CLI::App& app, Run& run);
void add_compare(CLI::App& app, Run& run);
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
void add_devices(CLI::App& app, Run& run);
void add_doctor(CLI::App& app, Run& run);

// At the end of --help; without "ferrule". (main.cpp)
void add_examples(CLI::App& verb, const std::vector<std::string>& examples);

// Does what a command line says, of which `words` are all but the program's name; its exit code.
// With `job` it has the trials of all shards of that. Throws what the verb throws. (main.cpp)
int run_command(const std::vector<std::string>& words);
int run_command(const std::vector<std::string>& words, SharedJob& job);

}  // namespace ferrule
