// ferrule submit: a job as an array of Slurm, and its merge.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <thread>

#include "app/interrupt.hpp"
#include "app/progress.hpp"
#include "app/provenance.hpp"
#include "app/shards.hpp"
#include "app/standard_streams.hpp"
#include "app/validators.hpp"

namespace ferrule {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

constexpr double kShard = 20 * 60;  // what a shard is to take [s]
constexpr double kLongest = 30 * 60;
constexpr double kShortest = 10 * 60;     // time limit of a task, at least [s]
constexpr std::size_t kUsualSize = 1001;  // MaxArraySize, where Slurm does not say it

struct SubmitArguments {
  std::string out, partition;
  std::size_t nodes = 0, shards = 0;  // 0: as many as there are; as many as it takes
  bool now = false;
  Words command;
};

// How much work a job is.
struct Work {
  std::size_t trials = 0;
  double seconds = NAN;  // of one trial here, on all cores
};

// The number after `name` and an equals sign in what Slurm says of itself.
std::optional<std::size_t> setting_of_slurm(const std::string& said, std::string_view name) {
  const std::size_t at = said.find(name);
  if (at == said.npos) return std::nullopt;
  const std::size_t begin = said.find_first_not_of(" \t=", at + name.size());
  std::size_t number = 0;
  const char* const end = said.data() + said.size();
  if (begin == said.npos || std::from_chars(said.data() + begin, end, number).ec != std::errc())
    return std::nullopt;
  return number;
}

// So many tasks an array has at most, from 1 on. Throws BadInput where Slurm takes no arrays.
std::size_t most_tasks() {
  std::string said;
  if (std::FILE* const config = ::popen("scontrol show config 2>/dev/null", "r")) {
    std::array<char, 4096> part{};
    while (const std::size_t size = std::fread(part.data(), 1, part.size(), config))
      said.append(part.data(), size);
    ::pclose(config);
  }
  // Larger than the largest index.
  const std::size_t size = setting_of_slurm(said, "MaxArraySize").value_or(kUsualSize);
  if (size < 2)
    throw BadInput(fmt::format(
        "submit: Slurm takes no arrays here (MaxArraySize = {}): submit each shard as a job of its "
        "own, with --shard I/N (docs/scale.md)",
        size));
  return std::min(size - 1, std::max<std::size_t>(
                                1, setting_of_slurm(said, "max_array_tasks").value_or(size - 1)));
}

// Runs a part of the job's trials in `folder`, and says how long that took [s].
double run_part(const Words& job, const Shard& shard, const std::string& folder) {
  Words words = job;
  for (const std::string& word :
       {std::string("--shard"), to_text(shard), std::string("--out"), folder})
    words.push_back(word);
  const auto begin = std::chrono::steady_clock::now();
  {
    const MutedOutput muted;
    run_command(words);
  }
  end_if_interrupted();
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  return took.count();
}

// Measured: a shard without a trial tells of all campaigns, and then some trials of each are run.
Work measured(const Words& job, const std::string& out) {
  std::string folder = out + "/measured.XXXXXX";
  if (!::mkdtemp(folder.data())) throw FileTrouble(folder + ": cannot be made");
  const std::unique_ptr<std::string, void (*)(const std::string*)> removed(
      &folder, [](const std::string* name) { fs::remove_all(*name); });
  constexpr std::size_t kNone = 1'000'000'000;  // more than there can be trials in a campaign
  constexpr std::size_t kEach = 8, kAll = 200;  // trials: of each campaign, and together, at least
  const double empty = run_part(job, {kNone, kNone}, folder + "/empty");
  const auto begun = [](const std::string& part) {
    ShardFiles files(part, read_job(part).hash);
    files.read_all();
    return files.progress();
  };
  const JobProgress all = begun(folder + "/empty");
  if (all.begun == 0) throw BadInput("submit: the job has no trials");
  const std::size_t some = std::min(all.begun, std::max(kAll, kEach * all.campaigns));
  fs::create_directories(folder + "/some");
  if (fs::exists(folder + "/empty/learned"))
    fs::copy(folder + "/empty/learned", folder + "/some/learned", fs::copy_options::recursive);
  const double took = run_part(job, {1, all.begun / some}, folder + "/some");
  const JobProgress done = begun(folder + "/some");
  return {all.begun,
          std::max(0.0, took - empty) / static_cast<double>(std::max<std::size_t>(1, done.trials))};
}

// Splits off what merge is told.
std::pair<Words, Words> split_telling(const Words& words) {
  Words job, telling;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string name = words[i].substr(0, words[i].find('='));
    const bool tells =
        std::find(kTellingOptions.begin(), kTellingOptions.end(), name) != kTellingOptions.end();
    Words& to = tells ? telling : job;
    to.push_back(words[i]);
    const bool flag = name == "--json" || name == "--csv" || words[i].size() > name.size();
    if (tells && !flag && i + 1 < words.size()) to.push_back(words[++i]);
  }
  return {job, telling};
}

std::string quoted_words(const Words& words) {
  std::string text;
  for (const std::string& word : words) text += " " + shell_quoted(word);
  return text;
}

// Where the scripts are, and what they begin with. What Slurm reads names no folder: there a percent
// sign and a backslash mean something else, and a line ends. submit.sh goes where the logs are to be.
struct Scripts {
  std::string folder, program, here;

  static Scripts of(const SubmitArguments& a) {
    return {fs::absolute(a.out).lexically_normal().string(),
            fs::read_symlink("/proc/self/exe").string(), fs::current_path().string()};
  }
  // `settings` of sbatch, each with its two dashes; then the program with these words.
  void write(const char* name, const SubmitArguments& a, Words settings,
             const std::string& words) const {
    for (const char* each : {"--nodes=1", "--ntasks=1", "--requeue"}) settings.emplace_back(each);
    if (!a.partition.empty()) settings.push_back("--partition=" + a.partition);
    std::string text = "#!/bin/sh\n";
    for (const std::string& setting : settings) text += "#SBATCH " + setting + "\n";
    write_script(name, text + "cd " + shell_quoted(here) + " || exit\nexec " +
                           shell_quoted(program) + words + "\n");
  }
  void write_script(const char* name, const std::string& text) const {
    const std::string file = folder + "/" + name;
    write_text(file, text);
    fs::permissions(file, fs::perms::owner_exec, fs::perm_options::add);
  }
};

// sbatch says the number of the array, and after a semicolon its cluster where there are several;
// sites may say more before.
constexpr const char* kSubmit = R"(said=$(sbatch --parsable "$@" ./array.sh) || exit
job=$(printf '%s\n' "$said" | sed -n '/^[0-9][0-9]*\(;.*\)\{0,1\}$/p' | tail -n 1)
if [ -z "$job" ]; then
  printf 'sbatch said no number of a job: %s\n' "$said" >&2
  exit 1
fi
case $job in
  *\;*) set -- --clusters="${job#*;}" ;;
  *) set -- ;;
esac
sbatch --dependency=afterany:"${job%%;*}" "$@" ./merge.sh
)";

// The array, its merge, and what submits both.
void write_scripts(const SubmitArguments& a, const Words& job, const Words& telling,
                   std::size_t shards, double minutes) {
  const Scripts scripts = Scripts::of(a);
  Words settings = {
      "--job-name=ferrule", "--exclusive", "--open-mode=append", "--output=shard_%a.log",
      fmt::format("--array=1-{}{}", shards, a.nodes > 0 ? fmt::format("%{}", a.nodes) : "")};
  if (!std::isnan(minutes)) settings.push_back(fmt::format("--time={:.0f}", minutes));
  scripts.write("array.sh", a, settings,
                fmt::format("{} --shard \"$SLURM_ARRAY_TASK_ID/{}\"{}", quoted_words(job), shards,
                            quoted_words({"--out", a.out})));
  scripts.write(
      "merge.sh", a,
      {"--job-name=ferrule-merge", "--open-mode=truncate", "--output=result", "--error=merge.log"},
      " merge" + quoted_words({a.out}) + (program_in(job).empty() ? "" : " --programs") +
          quoted_words(telling));
  scripts.write_script("submit.sh",
                       "#!/bin/sh\ncd " + shell_quoted(scripts.folder) + " || exit\n" + kSubmit);
}

int submit_verb(const SubmitArguments& a) {
  const auto [job, telling] = split_telling(a.command);
  if (job.empty()) throw BadInput("submit: which job? as in -- evaluate controller.json");
  expect_utf_8(job);
  const std::size_t most = most_tasks();
  if (a.shards > most)
    throw BadInput(
        fmt::format("--shards {}: an array of Slurm has at most {} here", a.shards, most));
  const bool unknown = job.front() == "map" || job.front() == "improve" || job.front() == "record";
  if (a.shards == 0 && unknown)
    throw BadInput("submit " + job.front() + ": give --shards: how long it takes shows as it runs");
  std::error_code error;
  fs::create_directories(a.out, error);
  if (error) throw FileTrouble(a.out + ": " + error.message());
  std::size_t shards = a.shards;
  double limit = NAN;  // of a shard [minutes]
  std::string each;
  if (shards == 0) {
    const Work work = measured(job, a.out);
    const double all = work.seconds * static_cast<double>(work.trials);
    shards = std::clamp<std::size_t>(static_cast<std::size_t>(std::ceil(all / kShard)), 1, most);
    const double shard = all / static_cast<double>(shards);
    limit = std::ceil(std::max(kShortest, 3 * shard) / 60);
    fmt::print("{} trials of {:.3g} ms on the {} threads here: {:.3g} hours of such a node\n",
               work.trials, 1e3 * work.seconds, std::thread::hardware_concurrency(), all / 3600);
    each = fmt::format(", {:.3g} minutes each, ended after {:.0f}", shard / 60, limit);
    if (shard > kLongest) each += fmt::format(" (an array of Slurm has at most {} here)", most);
  }
  write_scripts(a, job, telling, shards, limit);
  const std::string script = (fs::path(a.out) / "submit.sh").string(), sh = "sh ";
  fmt::print("{} shards, each with a node of its own{}{}\n", shards,
             a.nodes > 0 ? fmt::format(", {} at once", a.nodes) : "", each);
  if (!a.now) {
    fmt::print("submit them with: {}\n", sh + shell_word(script));
    return kDone;
  }
  std::fflush(stdout);
  if (std::system((sh + shell_quoted(fs::absolute(script))).c_str()) != 0)
    throw FileTrouble(script + ": Slurm did not take it");
  fmt::print("what merge prints will be in {}/result\n", printable(a.out));
  return kDone;
}

}  // namespace

void add_submit(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand("submit", "Run a job on the nodes of a cluster, by Slurm");
  auto a = std::make_shared<SubmitArguments>();
  verb->add_option("--out", a->out, "Folder that all nodes share")->required()->type_name("DIR");
  verb->add_option("--partition", a->partition, "Of Slurm; its own choice unless given")
      ->check(CLI::Validator(
          [](const std::string& names) {
            const bool plain = names.find_first_of(" \t\r\n\"'\\#") == names.npos;
            return plain ? std::string() : "must be a name, or several with commas, not " + names;
          },
          ""));
  verb->add_option("--nodes", a->nodes, "At most so many at once")->check(whole_number(1, 100000));
  verb->add_option("--shards", a->shards,
                   "How many; unless given, so that each takes 20 minutes, as measured here")
      ->check(whole_number(1, 4000000));
  verb->add_flag("--now", a->now, "Submit it too");
  verb->add_option("job", a->command, "After --: the verb and what it takes")
      ->required()
      ->type_name("-- VERB ...");
  add_examples(*verb,
               {"submit --out job --nodes 50 -- evaluate controller.json --trials 10000000",
                "submit --out job --now -- compare episodes search --ladder --seeds 1..5 --json"});
  verb->callback([a, &run] { run.verb = [a] { return submit_verb(*a); }; });
}

}  // namespace ferrule
