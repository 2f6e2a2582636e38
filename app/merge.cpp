// ferrule merge: what one process would print, from the trials that shards have run.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "app/interrupt.hpp"
#include "app/progress.hpp"
#include "app/shards.hpp"

namespace ferrule {
namespace {

struct MergeArguments {
  std::string folder;
  bool watch = false, programs = false;
};

using Clock = std::chrono::steady_clock;

std::string how_far(const JobProgress& p, double rate) {
  std::string text = fmt::format("{} of {} trials, {} of {} shards whole", p.trials, p.begun,
                                 p.count() - p.not_done().count, p.count());
  if (rate > 0 && p.begun > p.trials)
    text += fmt::format(", {:.3g} trials a second, {:.0f} s left", rate,
                        static_cast<double>(p.begun - p.trials) / rate);
  return text;
}

// Until all shards are whole.
void watch(ShardFiles& files) {
  JobProgress p = files.progress();
  const std::size_t before = p.trials;
  const auto begin = Clock::now();
  std::size_t told = SIZE_MAX;
  while (p.counts.empty() || p.not_done().count > 0) {
    end_if_interrupted();
    const std::chrono::duration<double> seconds = Clock::now() - begin;
    if (p.trials != told)
      fmt::print(stderr, "{}\n",
                 how_far(p, static_cast<double>(p.trials - before) / seconds.count()));
    told = p.trials;
    for (int i = 0; i < 20 && !interrupted(); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    files.read_all();
    p = files.progress();
  }
}

void expect_whole(const std::string& folder, const JobProgress& p) {
  if (p.others > 0)
    fmt::print(stderr, "note: {}: {} blocks are of another job and are left out\n", folder,
               p.others);
  for (const std::string& file : p.damaged)
    fmt::print(stderr, "note: {}: a part of it is damaged and is left out\n", file);
  if (p.counts.empty()) throw FileTrouble(folder + ": no shard of this job has begun");
  if (const JobProgress::NotDone left = p.not_done(); left.count > 0)
    throw FileTrouble(fmt::format("{}: {} {} not whole ({}): run {} again, or wait with --watch",
                                  folder, to_text(left.first, left.count),
                                  left.count == 1 ? "is" : "are", how_far(p, 0),
                                  left.count == 1 ? "it" : "them"));
}

int merge_verb(const MergeArguments& a, const std::vector<std::string>& telling) {
  for (const std::string& word : telling)
    if (word.starts_with("-") &&
        !std::count(kTellingOptions.begin(), kTellingOptions.end(), word.substr(0, word.find('='))))
      throw BadInput("merge: " + word +
                     ": takes --json, --csv and the files that the job's verb can write");
  const Job job = read_job(a.folder);
  if (const std::string program = program_in(job.arguments); !program.empty() && !a.programs)
    throw BadInput(fmt::format(
        "{}: the job runs a program with your rights: {}; read it, and merge with --programs",
        a.folder, printable(program, 300)));
  ShardFiles files(a.folder, job.hash);
  files.read_all();
  if (a.watch) watch(files);
  expect_whole(a.folder, files.progress());
  SharedJob all{.folder = a.folder,
                .store = std::make_unique<TrialStore>(a.folder, job.hash, std::nullopt, false)};
  std::vector<std::string> words = job.arguments;
  words.insert(words.end(), telling.begin(), telling.end());
  const int code = run_command(words, all);
  if (const std::size_t twice = all.store->twice(); twice > 0)
    fmt::print(stderr, "note: {}: {} trials are there twice, and count once\n", a.folder, twice);
  return code;
}

}  // namespace

void add_merge(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand(
      "merge", "Print what one process would have printed, from the shards of a job");
  auto a = std::make_shared<MergeArguments>();
  verb->add_option(
          "folder", a->folder,
          "That was --out of the shards; after it --json, --csv, --report FILE and what else "
          "the job's verb can write")
      ->required()
      ->type_name("DIR");
  verb->add_flag("--watch", a->watch, "Show how far they are, and wait until all are whole");
  verb->add_flag("--programs", a->programs,
                 "Run the programs that the job names: --policy COMMAND, TorchScript");
  verb->allow_extras();
  add_examples(*verb, {"merge job", "merge job --watch --json", "merge job --report page.html"});
  verb->callback([a, verb, &run] {
    run.verb = [a, telling = verb->remaining()] { return merge_verb(*a, telling); };
  });
}

}  // namespace ferrule
