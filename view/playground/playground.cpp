// The simulator within a page: compiled to WebAssembly it runs in a worker of the browser, and answers the page as
// view/session.cpp does over a socket. It records no files: a try is kept as an input log (view/input_log.hpp), which
// the page saves.
//
// Messages from the page beside those of view/message.hpp:
//   {"type":"scene","name":text}          another of the shipped scenes
//   {"type":"insert","controller":text}   that shipped controller inserts, from the start of the next try
//   {"type":"save","file":text}           the log of that try, answered by {"type":"log","file","text"}
// "hello" has "scenes" and "controllers" (that know the scene's scaling), their names, beside what view/said.hpp states. There is no "fit".
#include <emscripten.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <optional>

#include "capture/score.hpp"
#include "controller/controller_file.hpp"
#include "controller/trial.hpp"
#include "insertion/hand_device.hpp"
#include "insertion/loop.hpp"
#include "sim/base/content_hash.hpp"
#include "sim/base/control_period.hpp"
#include "sim/base/data_folder.hpp"
#include "sim/base/shipped_files.hpp"
#include "view/browser_device.hpp"
#include "view/frame.hpp"
#include "view/input_log.hpp"
#include "view/message.hpp"
#include "view/said.hpp"

// To the page: a text, and frames as view/README.md has their layout.
EM_JS(void, post_text, (const char* text), { postMessage(UTF8ToString(text)); });
EM_JS(void, post_frames, (int kind, const float* frames, int rows, int columns, unsigned heard), {
  const packet = new ArrayBuffer(16 + 4 * rows * columns);
  new Uint32Array(packet, 0, 4).set([ kind, rows, columns, heard ]);
  new Float32Array(packet, 16).set(HEAPF32.subarray(frames / 4, frames / 4 + rows * columns));
  postMessage(packet, [packet]);
});

namespace ferrule {

std::string data_folder() {
  return "/data";
}

namespace {

constexpr std::uint64_t kSeed = 1;
constexpr double kMostBehind = 0.1;                            // more time than that is let go [s]
constexpr double kStateEvery = 1.0 / 60, kHistoryEvery = 0.1;  // [s]
constexpr ShippedFiles kControllers = {"controllers", "controller file", "controller"};
constexpr const char* kFirstScene = "easy";

void say(const char* type, Json json) {
  json["type"] = type;
  post_text(json.dump(-1, ' ', false, Json::error_handler_t::replace).c_str());
}

// The shipped controllers that learned with the scene's scaling.
std::vector<std::string> suitable(const Scene& scene) {
  std::vector<std::string> names = kControllers.names();
  std::erase_if(names, [&](const std::string& name) {
    return !scaling_trouble(trained_on(read_controller(name)).scaling, name, scene).empty();
  });
  return names;
}

// A person's hand, or a controller's, until the page stops it.
class StoppedHand : public Device {
 public:
  explicit StoppedHand(Device& hand) : hand_(hand) {}
  HandSample read(double t) override {
    HandSample sample = hand_.read(t);
    sample.finished = sample.finished || finish_;
    return sample;
  }
  void render(const HandWrench& wrench) override { hand_.render(wrench); }
  void holder_at(const HandPose& holder) override { hand_.holder_at(holder); }
  const Mapping* mapping() const noexcept override { return hand_.mapping(); }
  void finish() noexcept { finish_ = true; }

 private:
  Device& hand_;
  bool finish_ = false;
};

// An insertion that runs, tick by tick.
struct Running {
  TrialSetup trial;
  std::unique_ptr<Controller> controller;  // null: a person
  const BrowserDevice* browser;            // his hand; or null
  std::unique_ptr<Device> hand;
  StoppedHand stopped{*hand};
  FrameMaker make{*trial.scene, trial.sensor, kControlPeriod};
  Insertion insertion{trial, stopped, {}};
  double due = 0;                 // how much of it is still to be computed [s]
  std::vector<Frame> frames{};    // that the page has not got
  double said = 0, all_said = 0;  // when it got the newest, and all [s]
  // Of a person's try.
  InputLog log{};
  std::vector<RowVector> rows{};
};

class Playground {
 public:
  Playground() { choose(kFirstScene); }

  // A message of the page.
  void hear(std::string_view text);
  // So much time passed [s].
  void advance(double seconds);
  // There is time.
  void idle() {
    if (!running_) measure_yardstick();
  }

 private:
  void obey(const Message& message);
  // What tries are measured by; takes a second, once.
  void measure_yardstick();
  void choose(const std::string& scene);
  void prepare();
  void begin(std::unique_ptr<Controller> controller, const BrowserDevice* browser,
             std::unique_ptr<Device> hand);
  void start_try();
  void insert(const std::string& controller);
  bool tick();  // whether there is another one
  void end();
  void end_try(const InsertionEnd& end, Json& ended);
  void send_frames(bool all);
  void save(const std::string& file) const;
  void say_state() const;
  void say_episodes() const { say("episodes", {{"list", episodes_}, {"reading", 0}}); }

  std::unique_ptr<Scene> written_;        // before parts are drawn
  std::vector<std::string> controllers_;  // that know its scaling
  int number_ = 1;                        // of the next try
  TrialSetup prepared_;
  BrowserHand hand_;
  std::unique_ptr<Running> running_;
  bool discards_ = false;
  std::string trainee_, began_ = date_now();
  std::optional<Yardstick> yardstick_;
  bool measured_ = false;
  Json episodes_ = Json::array();
  std::map<std::string, std::string> logs_;
};

void Playground::hear(std::string_view text) try {
  const Json json = Json::parse(text, nullptr, false);
  const std::string type = json.is_object() ? json.value("type", "") : "";
  if (type == "scene") return choose(json.value("name", ""));
  if (type == "insert") return insert(json.value("controller", ""));
  if (type == "save") return save(json.value("file", ""));
  const Message message = parse_message(text);
  if (const auto* hand = std::get_if<HandMessage>(&message)) return hand_.say(*hand);
  obey(message);
} catch (const std::exception& error) {
  say("error", {{"text", printable(error.what(), 400)}});
}

void Playground::obey(const Message& message) {
  const bool discard = std::holds_alternative<DiscardMessage>(message);
  if (const auto* trainee = std::get_if<TraineeMessage>(&message)) {
    trainee_ = trainee->name;
    return say_state();
  }
  if (running_ && (discard || std::holds_alternative<StopMessage>(message))) {
    discards_ = discard;
    return running_->stopped.finish();
  }
  if (running_) throw BadInput("an insertion runs: stop or discard it first");
  if (std::holds_alternative<StartMessage>(message)) {
    start_try();
    return say_state();
  }
  if (discard && !episodes_.empty()) {
    logs_.erase(episodes_.back()["file"]);
    episodes_.erase(episodes_.end() - 1);
    say_episodes();
  }
}

void Playground::measure_yardstick() {
  if (!std::exchange(measured_, true)) yardstick_ = yardstick(*written_);
}

void Playground::choose(const std::string& scene) {
  if (running_) throw BadInput("an insertion runs: stop or discard it first");
  written_ = std::make_unique<Scene>(load_scene(scene));
  measured_ = false;
  yardstick_.reset();
  for (Json& episode : episodes_) episode["same_scene"] = episode["scene"] == written_->name;
  Json hello = hello_json(*written_, kBrowser, "");
  hello["scenes"] = shipped_scenes();
  hello["controllers"] = controllers_ = suitable(*written_);
  say("hello", hello);
  prepare();
  say_episodes();
}

// The next start, and its picture.
void Playground::prepare() {
  prepared_ = feasible_setup(*written_, kSeed, static_cast<std::uint64_t>(number_));
  say_state();
  start_try();
  running_->stopped.finish();
  while (tick()) {
  }
  send_frames(true);
  running_.reset();
}

void Playground::begin(std::unique_ptr<Controller> controller, const BrowserDevice* browser,
                       std::unique_ptr<Device> hand) {
  running_.reset(new Running{prepared_, std::move(controller), browser, std::move(hand)});
}

void Playground::start_try() {
  const Scene& scene = *prepared_.scene;
  auto hand =
      std::make_unique<BrowserDevice>(hand_, device_range(scene, 1).speed, prepared_.hand());
  const BrowserDevice& browser = *hand;
  begin(nullptr, &browser, std::move(hand));
  EpisodeInfo& info = running_->log.info = episode_info(scene, browser, kSeed, prepared_.trial);
  info.operator_ = (trainee_.empty() ? "" : trainee_ + ", ") + std::string(kBrowser);
  info.trainee = trainee_;
  info.date = date_now();
  info.session = began_;
}

void Playground::insert(const std::string& controller) {
  if (running_) throw BadInput("an insertion runs: stop or discard it first");
  if (std::find(controllers_.begin(), controllers_.end(), controller) == controllers_.end())
    throw BadInput("no controller of that name knows the scaling of this scene");
  std::unique_ptr<Controller> inserts = load_controller(controller)(prepared_.trial);
  auto hand = std::make_unique<ControllerHand>(recorded_hand(prepared_, *inserts));
  begin(std::move(inserts), nullptr, std::move(hand));
  say_state();
}

void Playground::advance(double seconds) {
  if (!running_) return;
  running_->due = std::min(running_->due + seconds, kMostBehind);
  for (; running_->due >= kControlPeriod; running_->due -= kControlPeriod)
    if (!tick()) return end();
  send_frames(false);
}

bool Playground::tick() {
  Running& r = *running_;
  return !r.insertion.feel() && !r.insertion.answer([&](const Tick& tick) {
    const RowVector row = make_row(tick);
    r.frames.push_back(r.make(row));
    if (!r.controller) {
      r.rows.push_back(row);
      r.log.add(tick.sample.counts);
    }
    return true;
  });
}

void Playground::end() {
  const InsertionEnd end = *running_->insertion.end();
  send_frames(true);
  const bool discards = std::exchange(discards_, false), inserts = running_->controller != nullptr;
  Json ended = ended_json(end, prepared_.trial);
  ended["what"] = inserts ? "insert" : "try";
  if (!discards && !inserts) end_try(end, ended);
  running_.reset();
  if (discards) return prepare();
  say("ended", ended);
  if (inserts) return say_state();
  say_episodes();
  ++number_;
  prepare();
}

// Keeps it, and says how good it was.
void Playground::end_try(const InsertionEnd& end, Json& ended) {
  InputLog& log = running_->log;
  log.info.outcome = end.outcome;
  log.info.why = end.why;
  Episode episode{log.info, {}, {}};
  episode.rows.resize(static_cast<Eigen::Index>(running_->rows.size()), kRowSize);
  Sha1 hash;
  for (Eigen::Index n = 0; n < episode.rows.rows(); ++n) {
    episode.rows.row(n) = running_->rows[static_cast<std::size_t>(n)];
    hash.add(episode.rows.row(n).data(), sizeof(double) * kRowSize);
  }
  log.rows_sha1 = hash.text();
  const std::string file = fmt::format("try_{:04}.json", number_);
  logs_[file] = to_json(log).dump() + "\n";
  ended["file"] = file;
  const Scene& scene = *running_->trial.scene;
  const Measures measures = measure(episode, scene);
  measure_yardstick();
  std::optional<Score> scored;
  if (yardstick_) scored = score(measures, *yardstick_);
  if (scored) add_score(ended, measures, *scored);
  episodes_.push_back(
      listed_json(file, log.info, scene, measures, true, scored ? scored->total : NAN));
}

// What is due, or all there is.
void Playground::send_frames(bool all) {
  Running& r = *running_;
  if (r.frames.empty()) return;
  const double now = r.insertion.time();
  const auto post = [&](int kind, const Frame* frames, std::size_t count, std::uint32_t heard) {
    post_frames(kind, frames->data(), static_cast<int>(count), kFrameColumns, heard);
  };
  if (all || now - r.said >= kStateEvery) {
    post(1, &r.frames.back(), 1, r.browser ? r.browser->answered() : 0);
    r.said = now;
  }
  if (all || now - r.all_said >= kHistoryEvery) {
    post(2, r.frames.data(), r.frames.size(), 0);
    r.frames.clear();
    r.all_said = now;
  }
}

void Playground::save(const std::string& file) const {
  const auto log = logs_.find(file);
  if (log == logs_.end()) throw BadInput("there is no such try");
  say("log", {{"file", file}, {"text", log->second}});
}

void Playground::say_state() const {
  const bool inserts = running_ && running_->controller;
  say("state_of_session", {{"running", running_ != nullptr},
                           {"what", !running_ ? Json(nullptr) : Json(inserts ? "insert" : "try")},
                           {"episode", number_},
                           {"trial", prepared_.trial},
                           {"scene", scene_json(*prepared_.scene)},
                           {"device", kBrowser},
                           {"trainee", trainee_},
                           {"goes_on", false},
                           {"can_insert", !controllers_.empty()},
                           {"can_rate", false}});
}

std::optional<Playground> playground;

}  // namespace
}  // namespace ferrule

// For the worker that it runs in (view/page/src/playground.js).
extern "C" {
EMSCRIPTEN_KEEPALIVE void begin() {
  ferrule::playground.emplace();
}
EMSCRIPTEN_KEEPALIVE void hear(const char* text) {
  ferrule::playground->hear(text);
}
EMSCRIPTEN_KEEPALIVE void advance(double seconds) {
  ferrule::playground->advance(seconds);
}
EMSCRIPTEN_KEEPALIVE void idle() {
  ferrule::playground->idle();
}
}
