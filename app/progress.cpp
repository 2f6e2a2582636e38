#include "app/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <mutex>
#include <string_view>

#include "app/output.hpp"

namespace ferrule {
namespace {

// For programs that read stderr: FERRULE_PROGRESS=lines.
bool lines_wanted() {
  const char* const wanted = std::getenv("FERRULE_PROGRESS");
  return wanted && std::string_view(wanted) == "lines";
}

}  // namespace

struct Progress::State {
  using Clock = std::chrono::steady_clock;
  std::string what;
  std::size_t total;
  bool shown = ::isatty(STDERR_FILENO);
  bool lines = !shown && lines_wanted();
  Clock::time_point begin = Clock::now(), last = begin;
  std::mutex mutex;
};

Progress::Progress(std::string what, std::size_t total) : state_(std::make_shared<State>()) {
  state_->what = std::move(what);
  state_->total = total;
}

Progress::~Progress() {
  if (state_.use_count() == 1 && state_->shown) fmt::print(stderr, "\r\033[K");
}

void Progress::operator()(std::size_t done, const std::string& note, std::size_t total) {
  State& s = *state_;
  if (!s.shown && !s.lines) return;
  const std::lock_guard lock(s.mutex);
  if (total > 0) s.total = total;
  const auto now = State::Clock::now();
  if (done < s.total && now - s.last < std::chrono::milliseconds(100)) return;
  s.last = now;
  if (s.lines) return fmt::print(stderr, "progress {} {}\n", done, s.total);
  const double seconds = std::chrono::duration<double>(now - s.begin).count();
  const double rate = static_cast<double>(done) / std::max(seconds, 1e-9);
  const auto filled = std::min<std::size_t>(30, 30 * done / std::max<std::size_t>(1, s.total));
  const double left = static_cast<double>(s.total - std::min(done, s.total)) / rate;
  fmt::print(stderr, "\r\033[K{} [{}{}] {}/{}  {:.3g}/s  {} s left{}", s.what,
             std::string(filled, '#'), std::string(30 - filled, ' '), done, s.total, rate,
             number_or("?", "{:.0f}", left), note);
}

}  // namespace ferrule
