// ferrule view: the operator's window in a browser.
#include <fmt/format.h>
#include <spawn.h>

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <thread>

#include "app/damage.hpp"
#include "app/device_arguments.hpp"
#include "app/given_controller.hpp"
#include "app/html.hpp"
#include "app/interrupt.hpp"
#include "app/loaded_verb.hpp"
#include "app/output.hpp"
#include "app/recorded_view.hpp"
#include "app/recording.hpp"
#include "app/scene_arguments.hpp"
#include "app/trained.hpp"
#include "app/trial_arguments.hpp"
#include "app/validators.hpp"
#include "insertion/hand_device.hpp"
#include "insertion/scene_scaling.hpp"
#include "view/page_file.hpp"
#include "view/server.hpp"
#include "view/session.hpp"

extern char** environ;

namespace ferrule {
namespace {

struct ViewArguments {
  SceneArguments scene;
  DeviceArguments device;
  RecordedViewArguments recorded;
  std::string out = "ferrule-view", export_to;
  std::uint64_t seed = 1;
  std::uint16_t port = 0;
  bool no_open = false;
};

// Opens the window in the person's browser, where there is one. The browser is handed a file that
// only this user can read: other users of the machine see the command line of any program, and so
// an address in it. The file is gone once the page was asked for, or when this ends.
class Doorway {
 public:
  Doorway() = default;
  Doorway(const Doorway&) = delete;
  Doorway& operator=(const Doorway&) = delete;
  ~Doorway() { close(); }

  void open(const std::string& address) {
    namespace fs = std::filesystem;
    std::string folder = fs::temp_directory_path() / "ferrule-view.XXXXXX";
    if (!::mkdtemp(folder.data())) throw FileTrouble(folder + ": " + std::strerror(errno));
    folder_ = folder;
    std::string program = "xdg-open", file = folder_ + "/open.html";
    write_text(file, html_head("ferrule") + "<meta http-equiv=\"refresh\" content=\"0; url=" +
                         escaped(address) + "\">\n<p><a href=\"" + escaped(address) +
                         "\">the window</a></p>\n</body></html>\n");
    fs::permissions(file, fs::perms::owner_read | fs::perms::owner_write);
    char* words[] = {program.data(), file.data(), nullptr};
    pid_t child = -1;
    posix_spawn_file_actions_t quiet;
    ::posix_spawn_file_actions_init(&quiet);
    ::posix_spawn_file_actions_addopen(&quiet, 1, "/dev/null", 1, 0);
    ::posix_spawn_file_actions_addopen(&quiet, 2, "/dev/null", 1, 0);
    if (::posix_spawnp(&child, program.c_str(), &quiet, nullptr, words, environ) != 0)
      fmt::print(stderr, "note: there is no xdg-open here: open the address yourself\n");
    ::posix_spawn_file_actions_destroy(&quiet);
  }

  // In any thread, once open() was called.
  void close() const noexcept {
    std::error_code ignored;
    if (!folder_.empty()) std::filesystem::remove_all(folder_, ignored);
  }

 private:
  std::string folder_;
};

// Before the address is printed: nobody asks for the page until then.
void announce(const ViewArguments& a, const Provenance& provenance, const Server& server,
              Doorway& doorway) {
  if (!a.no_open) doorway.open(server.address());
  fmt::print("{}{}\n", provenance.head(), server.address());
  std::fflush(stdout);
}

// What a sitting has to know of an open device, which outlives it.
SessionDevice session_device(const OpenDevice& device, const HandSettings& settings) {
  SessionDevice made;
  made.name = operator_name(device);
  made.make = [&device, settings](const Scene& scene, const State& start) {
    return hand_on(device, settings, scene, start);
  };
  const ForceDriver* const force = device.driver->force;
  if (!force) return made;
  made.period = settings.profile.period;
  if (settings.coupling) made.coupling = coupling_text(*settings.coupling);
  made.feedback = [&device, settings, force](const Scene& scene, const State& start) {
    return std::make_unique<ForceFeedback>(
        settings.profile, settings.coupling, scene_scaling(scene).motion_to_hand(start.command),
        force->report_period, force->motors(device.transport->info()));
  };
  return made;
}

// Serves what was recorded, until it is stopped.
int replay_in_browser(const ViewArguments& a) {
  const std::string page = self_contained(load_page(), kServed);
  const RecordedView recorded(a.recorded, a.scene);
  Doorway doorway;
  Server server(a.port, {[&page, &doorway] {
                           doorway.close();
                           return std::string(page);
                         },
                         [&recorded](const std::string& file) { return recorded.json(file); },
                         [] { return std::vector<SharedPayload>(); },
                         [](std::uint64_t, std::string_view) {}});
  announce(a, recorded.provenance(), server, doorway);
  while (!interrupted()) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  return kInterrupted;
}

// One file that replays from disk.
int export_replay(const ViewArguments& a) {
  if (a.recorded.path.empty() && !a.recorded.trial)
    throw BadInput("view --export: give an episode, a folder of them, or --trial");
  expect_place_for(a.export_to);
  const std::string page = load_page();
  const RecordedView recorded(a.recorded, a.scene);
  write_text(a.export_to, self_contained(page, recorded.whole()));
  fmt::print("{}{}", recorded.provenance().head(), recorded.provenance().foot());
  return kDone;
}

int live_verb(const ViewArguments& a) {
  const std::string page = load_page();
  SessionSettings settings;
  const ChosenScene chosen = a.scene.choose();
  settings.scene = chosen.scene;
  fmt::print(stderr, "{}", damage_note(settings.scene));
  settings.seed = a.seed;
  settings.out = a.out;
  settings.trainee = a.device.trainee;
  settings.goes_on = a.device.goes_on;
  settings.program = "/proc/self/exe";
  std::optional<OpenDevice> device;
  if (!a.device.device.empty()) {
    device = open_device("--device", a.device.device);
    settings.device = session_device(*device, hand_settings(a.device, *device, settings.scene));
  }
  Provenance provenance;
  provenance.in(chosen).seed("starts", a.seed);
  Doorway doorway;
  std::unique_ptr<Server> server;
  Session session(std::move(settings), [&server](SharedPayload payload) {
    if (server) server->send(std::move(payload));
  });
  self_contained(page, session.first_picture());  // throws now where it is not our page
  server = std::make_unique<Server>(
      a.port, Server::Served{[&page, &session, &doorway] {
                               doorway.close();
                               return self_contained(page, session.first_picture());
                             },
                             [](const std::string&) { return std::optional<std::string>(); },
                             [&session] { return session.greeting(); },
                             [&session](std::uint64_t client, std::string_view text) {
                               session.message(client, text);
                             }});
  announce(a, provenance, *server, doorway);
  const auto close = [&server] { server.reset(); };
  try {
    session.run(interrupted);
  } catch (...) {
    close();
    throw;
  }
  close();
  return kInterrupted;
}

int view_verb(ViewArguments a) {
  a.recorded.seed = a.seed;
  if (!a.export_to.empty()) return export_replay(a);
  return a.recorded.path.empty() && !a.recorded.trial ? live_verb(a) : replay_in_browser(a);
}

// What is replayed, where nobody plays.
void add_recorded(CLI::App& verb, ViewArguments& a) {
  RecordedViewArguments& r = a.recorded;
  verb.add_option("recorded", r.path,
                  "Replay this: an episode or a folder of them; with --trial a controller. " +
                      std::string(kControllers))
      ->type_name("FILE.h5|DIR|" + std::string(kControllerType));
  auto* trial = verb.add_option("--trial", r.trial,
                                "Run this trial of a campaign with --seed again, and replay it")
                    ->check(whole_number(0, std::uint64_t{1} << 53));
  verb.add_option(
          "--against", r.against,
          "A second controller in the same trial, or the simulated \"operator\", drawn over "
          "the first")
      ->type_name("operator|" + std::string(kControllerType))
      ->needs(trial);
  add_skill(verb, r.skill, "Skill of the operator of --against");
  verb.add_flag("--supervise", r.supervise, "Under the supervisor, as in evaluate")->needs(trial);
  add_other_scaling(verb, r.other_scaling);
  verb.add_option("--export", a.export_to,
                  "Write one file that replays from disk, and serve nothing")
      ->type_name("FILE.html");
}

void add_view(CLI::App& verb, Run& run) {
  auto a = std::make_shared<ViewArguments>();
  add_recorded(verb, *a);
  a->scene.add_to(verb, "that of the controller's training, or demo without a controller");
  add_device(verb, a->device, "Hold the fibre with this device instead of the page");
  add_trainee(verb, a->device.trainee);
  add_go_on(verb, a->device.goes_on);
  verb.add_option("--out", a->out, "Folder for the episodes")
      ->capture_default_str()
      ->type_name("DIR");
  add_seed(verb, a->seed, "Seed of the starts");
  verb.add_option("--port", a->port, "Port on 127.0.0.1; 0: one that is free")
      ->capture_default_str()
      ->check(whole_number(0, 65535));
  verb.add_flag("--no-open", a->no_open, "Print the address only; open no browser");
  add_examples(verb, {"view --scene demo --trainee Ada --out ada", "view --device auto --no-open",
                      "view episodes", "view episodes/episode_0001.h5 --export episode.html",
                      "view --trial 3 controller.json --seed 7 --against constant-velocity"});
  verb.callback([a, &run] { run.verb = [a] { return view_verb(*a); }; });
}

}  // namespace

extern "C" {
extern const AddOptions ferrule_loaded_verb;
const AddOptions ferrule_loaded_verb = &add_view;
}

}  // namespace ferrule
