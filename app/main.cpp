#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <optional>
#include <system_error>

#include "app/interrupt.hpp"
#include "app/loaded_verb.hpp"
#include "app/provenance.hpp"
#include "app/replaced_files.hpp"
#include "app/shards.hpp"
#include "app/standard_streams.hpp"
#include "app/verbs.hpp"
#include "capture/episode.hpp"
#include "haptic/trouble.hpp"
#include "sim/base/unknown_name.hpp"

namespace ferrule {
namespace {

// Groups of --help, each with what is added after it.
void add_verbs(CLI::App& app, Run& run) {
  app.group("The job");
  add_demo(app, run);
  add_loaded_verb(app, run, "view", "The operator's window: insert in a browser, and watch");
  add_record(app, run);
  add_fit(app, run);
  add_improve(app, run);
  add_evaluate(app, run);
  add_compare(app, run);
  add_merge(app, run);
  add_submit(app, run);
  add_export(app, run);
  app.group("Answers for an engineer");
  add_sweep(app, run);
  add_map(app, run);
  add_sensitivity(app, run);
  add_report(app, run);
  add_limits(app, run);
  add_release(app, run);
  add_identify(app, run);
  app.group("Physics");
  add_scene(app, run);
  add_forces(app, run);
  add_contact(app, run);
  add_plan(app, run);
  add_loaded_verb(app, run, "bench",
                  "Speed against error of laws, stepping and controllers; capture");
  app.group("Devices");
  add_devices(app, run);
  add_doctor(app, run);
  app.group("Data");
  add_score(app, run);
  add_replay(app, run);
  add_recover(app, run);
  add_import(app, run);
  add_export_episodes(app, run);
}

int refused(const std::string& why, ExitCode code) {
  constexpr std::size_t kLongest = 1000;
  fmt::print(stderr, "ferrule: {}\n", printable(why, kLongest));
  return code;
}

std::vector<std::string> verbs(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* verb : app.get_subcommands({})) names.push_back(verb->get_name());
  return names;
}

// Names the first option that the chosen verb does not have; empty: there is none. Whatever else is
// wrong may follow from it.
std::string unknown_option(const CLI::App& app) {
  const CLI::App& verb = app.get_subcommands().empty() ? app : *app.get_subcommands().front();
  std::vector<std::string> known;
  for (const CLI::Option* option : verb.get_options())
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  for (const std::string& word : app.remaining(true)) {
    const std::string name = word.substr(0, word.find('='));
    if (name.starts_with("--") && name.size() > 2)
      return fmt::format("unknown option \"{}\"{}", name, did_you_mean(name, known));
  }
  return "";
}

// The option that was given again, though it takes one value; null: none was.
const CLI::Option* given_again(const CLI::App& app) {
  for (const CLI::App* verb : app.get_subcommands())
    for (const CLI::Option* option : verb->get_options())
      if (option->get_items_expected_max() == 1 && option->count() > 1 &&
          option->get_multi_option_policy() == CLI::MultiOptionPolicy::Throw)
        return option;
  return nullptr;
}

// Empty: a verb was chosen. Otherwise the program's exit code.
std::optional<int> parse(CLI::App& app, const std::vector<std::string>& words) {
  const std::vector<std::string> known = verbs(app);
  if (!words.empty() && !words[0].starts_with("-") &&
      std::find(known.begin(), known.end(), words[0]) == known.end())
    return refused(fmt::format("unknown verb \"{}\"{} (see ferrule --help)", words[0],
                               did_you_mean(words[0], known)),
                   kBadInput);
  try {
    app.parse(std::vector<std::string>(words.rbegin(), words.rend()));
  } catch (const CLI::Success& asked) {  // --help, --version
    return app.exit(asked);
  } catch (const CLI::ParseError& error) {
    if (const CLI::Option* option = given_again(app))
      return refused(option->get_name() + ": is given more than once", kBadInput);
    const std::string unknown = unknown_option(app);
    return refused((unknown.empty() ? error.what() : unknown) + " (see ferrule --help)", kBadInput);
  }
  return std::nullopt;
}

// Quiet where the reader of a pipe went away, as `head` does.
int unwritten_output(const std::string& why) {
  pollfd out{STDOUT_FILENO, POLLOUT, 0};
  const bool nobody_reads = ::poll(&out, 1, 0) == 1 && (out.revents & POLLERR);
  if (nobody_reads && !interrupted()) return kNobodyReads;
  return refused("standard output cannot be written" + why,
                 interrupted() ? kInterrupted : kFileTrouble);
}

int exit_code(const std::vector<std::string>& words) {
  try {
    const int code = run_command(words);
    std::cout.flush();
    if (!std::cout || std::fflush(stdout) != 0 || std::ferror(stdout)) return unwritten_output("");
    return code;
  } catch (const Stopped& stopped) {
    return refused("stopped before the end: " + stopped.kept, kInterrupted);
  } catch (const BadInput& error) {
    return refused(error.what(), kBadInput);
  } catch (const DeviceTrouble& trouble) {
    return refused(trouble.what(), kDeviceTrouble);
  } catch (const std::filesystem::filesystem_error& error) {
    return refused(error.what(), kFileTrouble);
  } catch (const std::system_error& error) {  // of fmt, which prints; a closed terminal ends it too
    return unwritten_output(": " + error.code().message());
  } catch (const std::bad_alloc&) {
    return refused("out of memory", kFileTrouble);
  } catch (const std::exception& error) {  // FileTrouble, and what nobody foresaw
    return refused(error.what(), kFileTrouble);
  }
}

}  // namespace

void add_examples(CLI::App& verb, const std::vector<std::string>& examples) {
  std::string text = "Examples:";
  for (const std::string& example : examples) text += "\n  ferrule " + example;
  verb.footer(text);
}

int run_command(const std::vector<std::string>& words) {
  SharedJob job;
  return run_command(words, job);
}

int run_command(const std::vector<std::string>& words, SharedJob& job) {
  CLI::App app("Simulate, record and learn the insertion of an optical fibre into a ferrule.",
               "ferrule");
  app.set_version_flag("--version", program_version() + " (" + program_build() + ")");
  app.require_subcommand(1);
  remember_command(words);
  Run run{{}, job};
  add_verbs(app, run);
  if (const std::optional<int> code = parse(app, words)) return *code;
  refuse_to_replace(words, job.folder);
  watch_for_interrupt();
  return run_shard(app, run);
}

}  // namespace ferrule

int main(int argc, char** argv) {  // NOLINT(bugprone-exception-escape): only without memory
  using namespace ferrule;
  secure_standard_streams();
  return exit_code({argv + std::min(argc, 1), argv + argc});
}
