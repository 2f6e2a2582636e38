// Messages to the page, and frames while an insertion runs.
#include <algorithm>
#include <array>
#include <bit>
#include <chrono>

#include "view/session.hpp"

namespace ferrule {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kRecent = 10000;  // frames for a page that comes in the middle
constexpr std::chrono::microseconds kStateEvery{16667}, kHistoryEvery{100000};

SharedPayload text(const Json& json) {
  return std::make_shared<Payload>(
      Payload{Payload::Kind::text, json.dump(-1, ' ', false, Json::error_handler_t::replace)});
}

// kind, rows, columns, `reserved`, and the numbers; little endian.
static_assert(std::endian::native == std::endian::little);
template <class Frames>
SharedPayload packed(std::uint32_t kind, const Frames& frames, std::uint32_t reserved) {
  const std::array<std::uint32_t, 4> head = {kind, static_cast<std::uint32_t>(frames.size()),
                                             kFrameColumns, reserved};
  auto payload = std::make_shared<Payload>();
  payload->kind = Payload::Kind::frames;
  payload->newest_only = kind == 1;
  payload->bytes.reserve(sizeof head + frames.size() * sizeof(Frame));
  payload->bytes.append(reinterpret_cast<const char*>(head.data()), sizeof head);
  for (const Frame& frame : frames)
    payload->bytes.append(reinterpret_cast<const char*>(frame.data()), sizeof(Frame));
  return payload;
}

}  // namespace

std::vector<SharedPayload> Session::greeting() {
  const std::lock_guard lock(mutex_);
  std::vector<SharedPayload> all;
  for (const char* type : {"hello", "state_of_session", "episodes", "fit", "ended"})
    if (const auto found = said_.find(type); found != said_.end()) all.push_back(found->second);
  if (!recent_.empty()) {
    all.push_back(packed(2, recent_, 0));
    all.push_back(packed(1, std::array<Frame, 1>{recent_.back()}, 0));
  }
  return all;
}

Json Session::first_picture() {
  const std::lock_guard lock(mutex_);
  Json frame = Json::array();
  if (!recent_.empty())
    for (const float x : recent_.back()) frame.push_back(number_or_null(x));
  return {{"mode", "live"},
          {"hello", Json::parse(said_.at("hello")->bytes)},
          {"state", Json::parse(said_.at("state_of_session")->bytes)},
          {"frame", frame}};
}

void Session::show(const Frame& frame) {
  pending_.push_back(frame);
  const std::lock_guard lock(mutex_);
  recent_.push_back(frame);
  if (recent_.size() > kRecent) recent_.pop_front();
}

// What is due, or all there is.
void Session::send_frames(bool all) {
  const Clock::time_point now = Clock::now();
  if (pending_.empty()) return;
  if (all || now - state_sent_ >= kStateEvery) {
    const BrowserDevice* browser = browser_;
    send_(packed(1, std::array<Frame, 1>{pending_.back()}, browser ? browser->answered() : 0));
    state_sent_ = std::max(state_sent_ + kStateEvery, now - kStateEvery);
  }
  if (all || now - history_sent_ >= kHistoryEvery) {
    send_(packed(2, pending_, 0));
    pending_.clear();
    history_sent_ = now;
  }
}

void Session::say(const char* type, Json json) {
  json["type"] = type;
  SharedPayload payload = text(json);
  {
    const std::lock_guard lock(mutex_);
    said_[type] = payload;
  }
  send_(std::move(payload));
}

void Session::complain(const std::string& why) {
  send_(text({{"type", "error"}, {"text", printable(why, 400)}}));
}

void Session::say_state() {
  const TrialSetup& shown = running_ && last_.scene ? last_ : prepared_;
  say("state_of_session", {{"running", running_ != nullptr},
                           {"what", running_ ? Json(running_) : Json(nullptr)},
                           {"episode", claim_ ? claim_->number() : 0},
                           {"trial", shown.trial},
                           {"scene", scene_json(*shown.scene)},
                           {"device", settings_.device ? settings_.device->name : kBrowser},
                           {"trainee", settings_.trainee},
                           {"goes_on", settings_.goes_on},
                           {"can_insert", static_cast<bool>(controller_)},
                           {"can_rate", kept_.has_value()}});
}

}  // namespace ferrule
