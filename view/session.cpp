#include "view/session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>

#include "controller/controller_file.hpp"
#include "controller/trial.hpp"
#include "insertion/hand_device.hpp"
#include "insertion/trial_setup.hpp"
#include "view/said.hpp"

namespace ferrule {
namespace {

using Clock = std::chrono::steady_clock;
namespace fs = std::filesystem;

constexpr std::size_t kMostCommands = 32;
constexpr std::chrono::milliseconds kIdle{20}, kHandOver{500};

// A device whose health is looked after, in the loop's thread, for another.
class WatchedDevice : public Device {
 public:
  WatchedDevice(Device& device, const ForceFeedback* feedback, double period)
      : device_(device), feedback_(feedback), expected_(period) {}

  HandSample read(double t) override {
    const Clock::time_point now = Clock::now();
    if (before_ != Clock::time_point()) {
      const double passed = std::chrono::duration<double>(now - before_).count();
      period_ = passed;
      worst_ = std::max(worst_.load(), passed);
      missed_ = missed_ + std::max(0.0, std::floor(passed / expected_) - 1);
    }
    before_ = now;
    return device_.read(t);
  }
  void render(const HandWrench& wrench) override {
    if (feedback_) energy_ = feedback_->energy();
    device_.render(wrench);
  }
  void holder_at(const HandPose& holder) override { device_.holder_at(holder); }
  const Mapping* mapping() const noexcept override { return device_.mapping(); }

  LoopHealth health() const noexcept { return {period_, worst_, missed_, energy_}; }

 private:
  Device& device_;
  const ForceFeedback* feedback_;
  double expected_;
  Clock::time_point before_;
  std::atomic<double> period_ = 0, worst_ = 0, missed_ = 0, energy_ = 0;
};

// Still, and done at once: the fibre as it hangs at the start.
class StillDevice : public Device {
 public:
  explicit StillDevice(const HandPose& pose) : pose_(pose) {}
  HandSample read(double t) override { return {pose_, t > 0}; }
  void render(const HandWrench&) override {}

 private:
  HandPose pose_;
};

}  // namespace

Session::Session(SessionSettings settings, std::function<void(SharedPayload)> send)
    : settings_(std::move(settings)), send_(std::move(send)) {
  std::error_code none;
  if (fs::is_directory(settings_.out, none))
    for (const std::string& file : episode_files(settings_.out)) unread_.push_back(file);
  say("hello", hello_json(settings_.scene, settings_.device ? settings_.device->name : kBrowser,
                          settings_.out));
  prepare(next_episode_number(settings_.out));
  say_episodes();
}

Session::~Session() = default;

void Session::message(std::uint64_t client, std::string_view text) {
  Message message = parse_message(text);
  if (const auto* hand = std::get_if<HandMessage>(&message)) {
    // One page at a time has the hand: another only once that is silent.
    const Clock::time_point now = Clock::now();
    if (client != hand_client_ && now - hand_heard_ < kHandOver) return;
    hand_client_ = client;
    hand_heard_ = now;
    return hand_.say(*hand);
  }
  const std::lock_guard lock(mutex_);
  if (commands_.size() >= kMostCommands) throw BadInput("message: too many at once");
  commands_.push_back(std::move(message));
  came_.notify_one();
}

std::string Session::episode_file(const std::string& name) {
  const std::lock_guard lock(mutex_);
  if (busy_) throw BadInput("an insertion runs");
  for (const Listed& listed : episodes_)
    if (file_name(listed.file) == name) return listed.file;
  throw BadInput("there is no such episode");
}

std::optional<Message> Session::next_command() {
  const std::lock_guard lock(mutex_);
  if (commands_.empty()) return std::nullopt;
  Message message = std::move(commands_.front());
  commands_.pop_front();
  return message;
}

void Session::run(bool (*stopped)() noexcept) {
  try {
    serve(stopped);
  } catch (const std::exception& error) {
    complain(error.what());
    throw;
  }
}

void Session::serve(bool (*stopped)() noexcept) {
  while (!stopped()) {
    if (const std::optional<Message> command = next_command()) {
      try {
        obey(*command, stopped);
      } catch (const BadInput& error) {
        complain(error.what());
      }
      continue;
    }
    watch_fit();
    if (!measured_) {
      measure_yardstick();
    } else if (!unread_.empty()) {
      read_one_more();
    } else {
      std::unique_lock lock(mutex_);
      came_.wait_for(lock, kIdle, [this] { return !commands_.empty(); });
    }
  }
}

// Once: while it waits for the first command, or when the first try has ended if that came sooner.
void Session::measure_yardstick() {
  if (!std::exchange(measured_, true)) yardstick_ = yardstick(settings_.scene);
}

void Session::obey(const Message& message, bool (*stopped)() noexcept) {
  if (std::holds_alternative<StartMessage>(message)) return start_try(stopped);
  if (std::holds_alternative<InsertMessage>(message)) return let_it_insert(stopped);
  if (std::holds_alternative<DiscardMessage>(message)) return discard_last();
  if (const auto* rating = std::get_if<RateMessage>(&message)) return rate(rating->stars);
  if (const auto* fit = std::get_if<FitMessage>(&message)) return start_fit(*fit);
  if (const auto* trainee = std::get_if<TraineeMessage>(&message)) {
    settings_.trainee = trainee->name;
    say_state();
  }
}

void Session::prepare(int first) {
  claim_.reset();
  claim_.emplace(settings_.out, first);
  prepared_ =
      feasible_setup(settings_.scene, settings_.seed, static_cast<std::uint64_t>(claim_->number()));
  show_at_rest(prepared_);
  say_state();
}

void Session::show_at_rest(TrialSetup trial) {
  trial.sensor = ForceSensor();
  StillDevice still(trial.hand());
  FrameMaker make(*trial.scene, trial.sensor, kControlPeriod);
  {
    const std::lock_guard lock(mutex_);
    recent_.clear();
  }
  run_insertion(trial, still, {}, [&](const Tick& tick) {
    show(make(make_row(tick)));
    return true;
  });
  send_frames(true);
}

// What a page wants of the insertion that runs.
Request Session::requested(bool& discard) {
  Request wanted = Request::go_on;
  while (const std::optional<Message> command = next_command()) {
    if (std::holds_alternative<StopMessage>(*command)) {
      wanted = Request::finish;
    } else if (std::holds_alternative<DiscardMessage>(*command)) {
      discard = true;
      wanted = Request::stop;
    } else if (const auto* fit = std::get_if<FitMessage>(&*command)) {
      try {
        start_fit(*fit);
      } catch (const BadInput& error) {
        complain(error.what());
      }
    } else {
      complain("an insertion runs: stop or discard it first");
    }
  }
  return wanted;
}

TimedEpisode Session::run_shown(
    const TrialSetup& trial, Device& device, ForceFeedback* feedback, double period,
    const std::function<void(const RowVector&, const RawCounts&)>& record, bool& discard,
    bool (*stopped)() noexcept) {
  FrameMaker make(*trial.scene, trial.sensor, period);
  WatchedDevice watched(device, feedback, period);
  {
    const std::lock_guard lock(mutex_);
    busy_ = true;
    recent_.clear();
    said_.erase("ended");
  }
  say_state();
  const auto end = [&] {
    send_frames(true);
    browser_ = nullptr;
    running_ = nullptr;
    const std::lock_guard lock(mutex_);
    busy_ = false;
  };
  try {
    TimedEpisode timed = run_in_time(
        trial, watched, {.period = period, .past_success = settings_.goes_on, .feedback = feedback},
        [&](const RowVector& row, const RawCounts& counts) {
          record(row, counts);
          show(make(row, watched.health()));
        },
        [&] {
          send_frames(false);
          watch_fit();
          return requested(discard);
        },
        stopped);
    end();
    return timed;
  } catch (...) {
    end();
    say_state();
    throw;
  }
}

void Session::start_try(bool (*stopped)() noexcept) {
  const TrialSetup now = last_ = prepared_;
  const Scene& scene = *now.scene;
  std::unique_ptr<Device> device;
  std::unique_ptr<ForceFeedback> feedback;
  const SessionDevice* other = settings_.device ? &*settings_.device : nullptr;
  if (other) {
    device = other->make(scene, now.start);
    if (other->feedback) feedback = other->feedback(scene, now.start);
  } else {
    auto browser = std::make_unique<BrowserDevice>(hand_, device_range(scene, 1).speed, now.hand());
    browser_ = browser.get();
    device = std::move(browser);
  }
  EpisodeInfo info = episode_info(scene, *device, settings_.seed, now.trial);
  info.operator_ = (settings_.trainee.empty() ? "" : settings_.trainee + ", ") +
                   (other ? other->name : kBrowser);
  info.trainee = settings_.trainee;
  info.date = date_now();
  info.session = began_;
  if (other) {
    info.period = other->period;
    info.coupling = other->coupling;
  }
  kept_.reset();
  const int number = claim_->number();
  Recorder& recorder = kept_.emplace(std::move(*claim_), info);
  claim_.reset();
  running_ = "try";
  bool discard = false;
  const TimedEpisode timed = run_shown(
      now, *device, feedback.get(), info.period,
      [&](const RowVector& row, const RawCounts& counts) { recorder.add(row, counts); }, discard,
      stopped);
  device.reset();  // disables motors before anything else
  if (discard || recorder.rows() == 0) {
    recorder.discard();
    kept_.reset();
    return prepare(number);
  }
  recorder.info().why = timed.end.why;
  recorder.info().loop = loop_json(timed.timing, info.period).dump();
  const std::string file = recorder.finish(timed.end.outcome);
  Json ended = ended_json(timed.end, now.trial);
  ended["loop"] = loop_json(timed.timing, info.period);
  ended["file"] = file_name(file);
  const Measures measures = measure(open_episode(file), scene);
  measure_yardstick();
  if (yardstick_) add_score(ended, measures, score(measures, *yardstick_));
  list(recorder.info(), measures, file, scene);
  ended["what"] = "try";
  say("ended", ended);
  say_episodes();
  if (timed.end.lost) throw DeviceTrouble("the device was lost; the try was ended and kept");
  if (!stopped()) prepare(number + 1);
}

void Session::let_it_insert(bool (*stopped)() noexcept) {
  if (!controller_) throw BadInput("there is no controller yet: fit one first");
  const TrialSetup& now = last_.scene ? last_ : prepared_;
  const std::unique_ptr<Controller> controller = controller_(now.trial);
  ControllerHand hand = recorded_hand(now, *controller);
  running_ = "insert";
  bool discard = false;
  const TimedEpisode timed = run_shown(
      now, hand, nullptr, kControlPeriod, [](const RowVector&, const RawCounts&) {}, discard,
      stopped);
  Json ended = ended_json(timed.end, now.trial);
  ended["loop"] = loop_json(timed.timing, kControlPeriod);
  ended["what"] = "insert";
  ended["controller"] = file_name(controller_file_);
  say("ended", ended);
  if (!stopped()) say_state();
}

}  // namespace ferrule
