// A sitting of a person at the window: tries one after the other, each recorded as `record` does
// it, scored, and put on the list that controllers are fitted from.
//
// Texts to the page (JSON, "type"): hello, state_of_session, ended, episodes, fit, error; frames as
// view/README.md has their layout. Messages from it: view/message.hpp.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "capture/haptic_loop.hpp"
#include "capture/recorder.hpp"
#include "capture/score.hpp"
#include "controller/controller.hpp"
#include "sim/base/control_period.hpp"
#include "view/background_fit.hpp"
#include "view/browser_device.hpp"
#include "view/frame.hpp"
#include "view/server.hpp"

namespace ferrule {

// A device other than the page.
struct SessionDevice {
  std::string name;  // of the operator in recordings
  // Throws DeviceTrouble.
  std::function<std::unique_ptr<Device>(const Scene&, const State& start)> make;
  // Null: a device without force.
  std::function<std::unique_ptr<ForceFeedback>(const Scene&, const State& start)> feedback;
  double period = kControlPeriod;
  std::string coupling;  // coupling_text, where there is one
};

struct SessionSettings {
  Scene scene;  // as it is written, before parts are drawn
  std::uint64_t seed = 1;
  std::string out;                      // folder of the episodes
  std::string trainee;                  // may be empty; pages name another between tries
  bool goes_on = false;                 // a try after the goal, until the person stops it
  std::string program;                  // the file of ferrule, for fits
  std::optional<SessionDevice> device;  // empty: the page is the device `browser`
};

class Session {
 public:
  // `send`: to all pages, from any thread. Throws FileTrouble, BadInput.
  Session(SessionSettings settings, std::function<void(SharedPayload)> send);
  ~Session();

  // For Server::Served, in its thread.
  std::vector<SharedPayload> greeting();
  // What a page draws before it has heard anything: {"mode": "live", "hello", "state" (as they were
  // said), "frame": the newest row, null where a number is none}.
  Json first_picture();
  void message(std::uint64_t client, std::string_view text);

  // The episode of the folder with that name. Throws BadInput where there is none, and while an
  // insertion runs, which reading it would disturb.
  std::string episode_file(const std::string& name);

  // Until `stopped`, in the calling thread; a try that runs then is ended and kept. Throws
  // DeviceTrouble, FileTrouble, of which the pages hear too.
  void run(bool (*stopped)() noexcept);

 private:
  // What the list says of an episode.
  struct Listed {
    std::string file;
    Json json;
  };

  void serve(bool (*stopped)() noexcept);
  std::optional<Message> next_command();
  void measure_yardstick();
  void obey(const Message& message, bool (*stopped)() noexcept);
  void prepare(int first);
  void start_try(bool (*stopped)() noexcept);
  void let_it_insert(bool (*stopped)() noexcept);
  TimedEpisode run_shown(const TrialSetup& trial, Device& device, ForceFeedback* feedback,
                         double period,
                         const std::function<void(const RowVector&, const RawCounts&)>& record,
                         bool& discard, bool (*stopped)() noexcept);
  Request requested(bool& discard);
  void start_fit(const FitMessage& message);
  void watch_fit();
  void rate(int stars);
  void discard_last();
  void read_one_more();
  void list(const EpisodeInfo& info, const Measures& m, const std::string& file,
            const Scene& scene);

  void show_at_rest(TrialSetup trial);
  void show(const Frame& frame);
  void send_frames(bool all);
  void say(const char* type, Json json);
  void say_state();
  void say_episodes();
  void complain(const std::string& why);

  SessionSettings settings_;
  std::function<void(SharedPayload)> send_;
  std::string began_ = date_now();
  BrowserHand hand_;
  std::atomic<const BrowserDevice*> browser_ = nullptr;

  // Of the thread that runs.
  std::optional<EpisodeClaim> claim_;
  TrialSetup prepared_, last_;
  std::optional<Recorder> kept_;  // the last try, finished
  std::optional<Yardstick> yardstick_;
  bool measured_ = false;           // the yardstick
  std::deque<std::string> unread_;  // files of the folder that the list does not have yet
  std::unique_ptr<BackgroundFit> fit_;
  MakeController controller_;
  std::string controller_file_;
  const char* running_ = nullptr;  // "try", "insert"
  std::vector<Frame> pending_;
  std::chrono::steady_clock::time_point state_sent_, history_sent_;

  // Of the server's thread.
  std::uint64_t hand_client_ = 0;
  std::chrono::steady_clock::time_point hand_heard_;

  std::mutex mutex_;  // of what follows
  std::condition_variable came_;
  std::deque<Message> commands_;
  std::map<std::string, SharedPayload> said_;  // the last text of each type
  std::deque<Frame> recent_;                   // for pages that come later
  std::vector<Listed> episodes_;
  bool busy_ = false;  // an insertion runs
};

}  // namespace ferrule
