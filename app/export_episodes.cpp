// ferrule export-episodes: recorded episodes in the formats of others, written by the Python
// package.
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "app/interrupt.hpp"
#include "app/output.hpp"
#include "app/validators.hpp"
#include "app/verbs.hpp"
#include "capture/episode.hpp"

namespace ferrule {
namespace {

struct ExportEpisodesArguments {
  std::string folder, robomimic, lerobot, csv, mcap;
  std::optional<double> rate;
  bool relative = false, json = false;
};

// What its `python3 -c` runs. Nothing is imported from the working folder, where strangers' files
// may be; sys is part of Python itself. (-P came with Python 3.11, and -I would leave out packages
// of the user.)
constexpr const char* kScript =
    "import sys\n"
    "if sys.path[:1] == ['']: del sys.path[0]\n"
    "import os, signal\n"
    "for ending in (signal.SIGINT, signal.SIGTERM):\n"  // until main() handles them
    "  signal.signal(ending, lambda *_: os._exit(130))\n"
    "try:\n"
    "  from ferrule.export_episodes import main\n"
    "except ImportError as error:\n"
    "  print('ferrule: export-episodes needs the Python package of ferrule '\n"
    "        '(pip install \"./python[data]\"; FERRULE_PYTHON names the Python that has it): '\n"
    "        + str(error), file=sys.stderr)\n"
    "  sys.exit(3)\n"
    "sys.exit(main())\n";

int export_episodes_verb(const ExportEpisodesArguments& a) {
  if (a.robomimic.empty() && a.lerobot.empty() && a.csv.empty() && a.mcap.empty())
    throw BadInput(
        "export-episodes: give --robomimic FILE.h5, --lerobot DIR, --csv DIR or --mcap DIR");
  if (episode_files(a.folder).empty()) throw BadInput(a.folder + ": holds no episode (*.h5)");
  const char* set = std::getenv("FERRULE_PYTHON");
  const std::string python = set && *set ? set : "python3";
  std::vector<std::string> words = {python, "-c", kScript};
  using Option = std::pair<const char*, const std::string&>;
  for (const auto& [option, value] :
       {Option("--robomimic=", a.robomimic), Option("--lerobot=", a.lerobot),
        Option("--csv=", a.csv), Option("--mcap=", a.mcap)})
    if (!value.empty()) words.push_back(option + value);
  if (a.rate) words.push_back(fmt::format("--rate={}", *a.rate));
  if (a.relative) words.emplace_back("--relative");
  if (a.json) words.emplace_back("--json");
  words.emplace_back("--");
  words.push_back(a.folder);
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  stop_watching_for_interrupt();  // from here on it is Python's
  end_if_interrupted();
  ::execvp(arguments[0], arguments.data());
  throw FileTrouble(python + ": cannot be run: " + std::strerror(errno));
}

}  // namespace

void add_export_episodes(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand("export-episodes",
                                  "Episodes for robomimic, LeRobot, spreadsheets and Foxglove");
  auto a = std::make_shared<ExportEpisodesArguments>();
  verb->add_option("folder", a->folder, "Folder with the episodes")->required()->type_name("DIR");
  verb->add_option("--robomimic", a->robomimic, "One HDF5 file as robomimic reads it")
      ->type_name("FILE.h5");
  verb->add_option("--lerobot", a->lerobot, "A LeRobot dataset, v3.0")->type_name("DIR");
  verb->add_option("--csv", a->csv, "A table of each episode")->type_name("DIR");
  verb->add_option("--mcap", a->mcap, "An MCAP file of each episode")->type_name("DIR");
  verb->add_option("--rate", a->rate,
                   "Rows a second; 20 for robomimic and LeRobot, all for the others")
      ->type_name("HZ")
      ->check(number_between(1e-3, 1e6));
  verb->add_flag("--relative", a->relative,
                 "For robomimic and LeRobot: wrenches relative to that at rest, as controllers "
                 "observe them");
  add_json(*verb, a->json);
  add_examples(*verb, {"export-episodes episodes --robomimic all.h5 --relative",
                       "export-episodes episodes --lerobot dataset --rate 50",
                       "export-episodes episodes --csv tables --mcap foxglove"});
  verb->callback([a, &run] { run.verb = [a] { return export_episodes_verb(*a); }; });
}

}  // namespace ferrule
