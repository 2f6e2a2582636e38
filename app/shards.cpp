#include "app/shards.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <map>

#include "app/interrupt.hpp"
#include "app/named_files.hpp"
#include "app/provenance.hpp"
#include "app/standard_streams.hpp"
#include "capture/episode.hpp"
#include "capture/recorder.hpp"
#include "sim/base/content_hash.hpp"

namespace ferrule {
namespace {

namespace fs = std::filesystem;

Shard shard_of(const std::string& text) {
  const auto slash = text.find('/');
  const auto number = [&](const std::string& part) -> std::size_t {
    if (part.empty() || part.size() > 10 || part.find_first_not_of("0123456789") != part.npos)
      return 0;
    return std::stoul(part);
  };
  const Shard shard = slash == text.npos
                          ? Shard{0, 0}
                          : Shard{number(text.substr(0, slash)), number(text.substr(slash + 1))};
  if (shard.index < 1 || shard.index > shard.count)
    throw BadInput("--shard " + text + ": must be I/N with I from 1 to N, as in 3/10");
  return shard;
}

// Of the files of a name; of several their names too.
std::string hash_of(const NamedFiles& named) {
  if (named.files.size() == 1 && !named.folder) return sha1_of_file(named.files.front());
  std::string all;
  for (const std::string& file : named.files)
    all += fs::path(file).filename().string() + " " + sha1_of_file(file) + "\n";
  return sha1(all);
}

// Of all that the words name after the verb, the folder of the job apart.
Json hashes(const std::vector<std::string>& words, const std::string& folder) {
  std::map<std::string, std::string> all;  // a name may be that of a scene and a controller
  for (const NamedFiles& named : named_files(words, folder)) all[named.name] += hash_of(named);
  return all;
}

std::string job_file(const std::string& folder) {
  return folder + "/job.json";
}

Json job_json(const std::vector<std::string>& words, const std::string& folder) {
  return {{"version", program_version()},
          {"build", program_build()},
          {"command", words},
          {"read", hashes(words, folder)}};
}

// A job.json. Throws FileTrouble, BadInput.
Json read_job_file(const std::string& file) {
  Json job = parse_json(read_text(file), file);
  const auto text = [](const Json& value) { return value.is_string(); };
  const Json words = job.is_object() ? job.value("command", Json()) : Json();
  if (!words.is_array() || words.empty() || !std::all_of(words.begin(), words.end(), text) ||
      !text(job.value("version", Json())) || !text(job.value("build", Json())) ||
      !job.value("read", Json()).is_object())
    throw BadInput(file + ": is not that of a job");
  return job;
}

// Words of a job, whose folder may have several names.
std::vector<std::string> without_folder(const Json& words) {
  return without_option(words, "--out");
}

std::string hash_of_job(Json job) {
  job["command"] = without_folder(job["command"]);
  return sha1(job.dump());
}

// The verbs that have --shard.
constexpr std::array kSharedVerbs = {"evaluate", "compare",     "sweep", "map",
                                     "improve",  "sensitivity", "record"};

// The value of an option, where it has one.
std::string option_value(const std::string& option, const std::vector<std::string>& words) {
  for (std::size_t i = 0; i < words.size(); ++i)
    if (words[i].starts_with(option + "="))
      return words[i].substr(option.size() + 1);
    else if (words[i] == option && i + 1 < words.size())
      return words[i + 1];
  return "";
}

// `words` are those that `folder` has in its job.json. Episodes are recorded where their job is.
void refuse_strange(const std::string& folder, const std::vector<std::string>& words) {
  const std::string& verb = words.front();
  if (std::find(kSharedVerbs.begin(), kSharedVerbs.end(), verb) == kSharedVerbs.end())
    throw BadInput(fmt::format("{}: \"{}\" is no verb of a job: must be one of {}",
                               job_file(folder), printable(verb, 40),
                               fmt::join(kSharedVerbs, ", ")));
  std::error_code error;
  const std::string out = option_value("--out", words);
  const bool records = verb == "record" && fs::equivalent(out, folder, error);
  for (const std::string& word : words)
    for (const std::string telling : kTellingOptions)
      if (word.substr(0, word.find('=')) == telling && !(records && telling == "--out"))
        throw BadInput(fmt::format(
            "{}: {}: a job prints nothing, and writes to its own folder alone", job_file(folder),
            printable(telling == "--out" ? "--out " + out : word, 300)));
}

// `there` is what `file` says, `here` what this process would do.
void refuse_other(const std::string& file, const Json& there, const Json& here) {
  for (const char* key : {"version", "build"})
    if (there.at(key) != here.at(key))
      throw BadInput(fmt::format("{}: was begun by ferrule {} ({}), this is {} ({})", file,
                                 there.at("version").get<std::string>(),
                                 there.at("build").get<std::string>(), program_version(),
                                 program_build()));
  if (without_folder(there.at("command")) != without_folder(here.at("command")))
    throw BadInput(fmt::format("{}: is another job, ferrule {}: give another --out", file,
                               printable(shell_words(there.at("command")), 300)));
  for (const auto& [name, hash] : there.at("read").items())
    if (here.at("read").value(name, "") != hash.get<std::string>())
      throw BadInput(file + ": " + name + " has changed since the job was begun");
}

// The command without what it says about the shard.
std::vector<std::string> job_words(std::vector<std::string> words) {
  for (const char* option : {"--shard", "--threads"}) words = without_option(words, option);
  return words.front() == "record" ? words  // its episodes are there too
                                   : without_option(words, "--out");
}

// Begins the job in its folder, or goes on with it. The hash of the job.
std::string begin_job(const std::string& folder) {
  const std::vector<std::string> words = job_words(command_words());
  expect_utf_8(words);
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw FileTrouble(folder + ": " + error.message());
  const Json here = job_json(words, folder);
  const bool holds_episodes = words.front() == "record" && next_episode_number(folder) > 1;
  if (!fs::exists(job_file(folder))) {
    if (holds_episodes)
      throw BadInput(folder + ": already holds episodes, of no job; choose another folder");
    try {
      write_text(job_file(folder), here.dump(1) + "\n", false);
    } catch (const FileTrouble&) {  // another shard was faster
      if (!fs::exists(job_file(folder))) throw;
    }
  }
  const Json there = read_job_file(job_file(folder));
  refuse_other(job_file(folder), there, here);
  return hash_of_job(there);
}

}  // namespace

void expect_utf_8(const std::vector<std::string>& words) {
  for (const std::string& word : words) try {
      Json(word).dump();
    } catch (const Json::type_error&) {
      throw BadInput(fmt::format("--shard: \"{}\" must be UTF-8, as the words of a job are",
                                 printable(word, 100)));
    }
}

void add_shard(CLI::App& verb, SharedJob& job, bool waits) {
  CLI::Option* out = verb.get_option_no_throw("--out");
  const bool own = out != nullptr;
  if (!own)
    out = verb.add_option("--out", job.out, "Folder that all shards share")->type_name("DIR");
  auto* shard = verb.add_option("--shard", job.shard,
                                "Run only this part of the trials, and keep them for ferrule merge")
                    ->type_name("I/N");
  shard->needs(out);
  if (!own) out->needs(shard);
  shard->each([&job, waits](const std::string&) { job.waits = waits; });
}

TimedController learned_once(const SharedJob& job, const std::string& what,
                             const std::function<ControllerFile()>& learn) {
  const std::string folder = job.folder + "/learned/" + sha1(what).substr(0, 16),
                    controller = "/controller.json", seconds = "/seconds.json";
  if (job.folder.empty() || !fs::exists(folder)) {
    const auto begin = std::chrono::steady_clock::now();
    const ControllerFile made = learn();
    end_if_interrupted();  // it may be cut short
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    if (job.folder.empty()) return {made, took.count()};
    std::error_code error;
    fs::create_directories(job.folder + "/learned", error);
    std::string beside = folder + ".XXXXXX";
    if (!::mkdtemp(beside.data())) throw FileTrouble(beside + ": " + std::strerror(errno));
    write_controller(beside + controller, made);
    write_text(beside + seconds, Json(took.count()).dump());
    fs::rename(beside, folder, error);
    if (error && !fs::exists(folder)) throw FileTrouble(folder + ": " + error.message());
    if (error) fs::remove_all(beside, error);  // another process was faster
  }
  return {read_controller(folder + controller),
          parse_json(read_text(folder + seconds), folder + seconds)};
}

int run_shard(const CLI::App& app, const Run& run) {
  SharedJob& job = run.job;
  if (job.shard.empty()) return run.verb();
  const Shard shard = shard_of(job.shard);
  const CLI::App& verb = *app.get_subcommands().front();
  const std::string folder = verb.get_option("--out")->as<std::string>();
  for (const std::string telling : kTellingOptions)
    if (const CLI::Option* option = verb.get_option_no_throw(telling);
        option && option->count() > 0 && telling != "--out")
      throw BadInput(fmt::format("{}: is for ferrule merge {}, not for a shard", telling, folder));
  const std::string hash = begin_job(folder);
  job.folder = folder;
  job.store = std::make_unique<TrialStore>(folder, hash, shard, job.waits);
  if (!job.store->locked())
    fmt::print(stderr,
               "note: {}: its file system has no locks: run each shard in one process at a time\n",
               printable(folder));
  try {
    const MutedOutput muted;
    run.verb();
  } catch (const Stopped&) {
  }
  if (interrupted()) {
    fmt::print(stderr, "stopped by {}: what is done is kept; the same command goes on with it\n",
               stopped_by());
    return kInterrupted;
  }
  job.store->finish();
  fmt::print("shard {} is whole; when all are: ferrule merge {}\n", to_text(shard),
             printable(folder));
  return kDone;
}

Job read_job(const std::string& folder) {
  const Json there = read_job_file(job_file(folder));
  const std::vector<std::string> words = there.at("command");
  refuse_strange(folder, words);
  refuse_other(job_file(folder), there, job_json(words, folder));
  return {words, hash_of_job(there)};
}

std::string program_in(const std::vector<std::string>& words) {
  for (const std::string& word : words)
    if (word == "--policy" || word.starts_with("--policy="))
      return "--policy " + option_value("--policy", words);
    else if (word.ends_with(".pt"))
      return word;
  return "";
}

}  // namespace ferrule
