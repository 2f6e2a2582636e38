// --shard: the trials of a verb, shared by several processes, on one machine or many
// (controller/trial_store.hpp). FOLDER/job.json says what is shared: the command, the files that
// it reads, and the program. `ferrule merge` brings the trials together.
#pragma once

#include <CLI/CLI.hpp>
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "app/verbs.hpp"
#include "controller/controller_file.hpp"
#include "controller/trial_store.hpp"

namespace ferrule {

// What a command shares with other processes: nothing, unless --shard or merge says so.
struct SharedJob {
  std::string shard{}, out{};           // --shard and --out, as they are given
  bool waits = false;                   // as of TrialStore
  std::string folder{};                 // empty: nothing is shared
  std::unique_ptr<TrialStore> store{};  // for run_campaigns; null: nothing is shared

  // What a shard finds is not told, and need not be computed.
  bool runs_a_shard() const noexcept { return store && !shard.empty(); }
};

// Adds --shard, and --out where the verb has none.
void add_shard(CLI::App& verb, SharedJob& job, bool waits = false);

// Throws BadInput where a word is not UTF-8: a job.json could not keep it.
void expect_utf_8(const std::vector<std::string>& words);

// A controller, and the time it took to learn it [s].
struct TimedController {
  ControllerFile controller;
  double seconds;
};
// What `learn` returns. Of the processes that share a job the first that needs it learns it, and
// keeps it as FOLDER/learned/WHAT; `what` tells it from others of the job. Throws what `learn`
// throws, FileTrouble.
TimedController learned_once(const SharedJob& job, const std::string& what,
                             const std::function<ControllerFile()>& learn);

// Does what the chosen verb of `app` does; with --shard its trials alone, of which nothing but that
// they are there is printed.
int run_shard(const CLI::App& app, const Run& run);

// The options with which a verb says what it found, which are those of merge.
inline constexpr std::array kTellingOptions = {"--json", "--csv",        "--report",
                                               "--plot", "--trials-out", "--out"};

// A job that shards have begun in a folder.
struct Job {
  std::vector<std::string> arguments;  // of the command, those of kTellingOptions apart
  std::string hash;
};
// A stranger may have made the folder: its job is one that shards can have begun, and writes
// nothing but there. Throws BadInput where it is another one, where another program has begun it,
// or a file that it reads has changed.
Job read_job(const std::string& folder);
// What of the command is a program that runs with it, --policy or TorchScript; empty: nothing is.
std::string program_in(const std::vector<std::string>& words);

}  // namespace ferrule
