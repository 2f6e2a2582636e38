#include "app/verb.hpp"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <iostream>
#include <mutex>
#include <thread>

#include "app/keys.hpp"
#include "sim/plan/plan.hpp"

namespace ferrule {
namespace {

// Ctrl-C, kill, a terminal that was closed, Ctrl-backslash.
constexpr int kEndings[] = {SIGINT, SIGTERM, SIGHUP, SIGQUIT};

std::atomic<int> g_interrupted = 0;                    // the signal
static_assert(std::atomic<int>::is_always_lock_free);  // for the signal handler

void on_interrupt(int which) {
  if (g_interrupted) {
    restore_terminal();
    ::_exit(kInterrupted);
  }
  g_interrupted = which;
}

double parse_number(const std::string& text, const std::string& option) {
  std::size_t used = 0;
  double value = NAN;
  try {
    value = std::stod(text, &used);
  } catch (const std::exception&) {
  }
  if (used != text.size() || !std::isfinite(value))
    throw BadInput(option + " " + text + ": must be a number or from:to:count[:log]");
  return value;
}

}  // namespace

void SceneArguments::add_to(CLI::App& verb, const std::string& default_scene) {
  scene = default_scene;
  verb.add_option("--scene", scene, "Scene file, or the name of one that ships with the program")
      ->capture_default_str()
      ->type_name("NAME|FILE");
  verb.add_option("--set", settings, "Change one value of the scene; may be given again")
      ->type_name("KEY=VALUE")
      ->expected(1)
      ->take_all();
}

Scene SceneArguments::load() const {
  Scene loaded = planned(load_scene(scene, settings));
  const auto number = [&](const char* key) { return loaded.document.value(key, 0.0); };
  if (const double bound = number("planned_error_bound"); bound > number("planned_accuracy"))
    fmt::print(stderr,
               "note: accuracy = {:g} is not reached: the error bound of the plan is {:.2g} "
               "(see ferrule plan)\n",
               number("planned_accuracy"), bound);
  return loaded;
}

void add_seed(CLI::App& verb, std::uint64_t& seed, const std::string& help) {
  const auto whole = [](const std::string& text) {
    const bool digits = !text.empty() && text.find_first_not_of("0123456789") == text.npos;
    const bool fits = text.size() < 19 || (text.size() == 19 && text <= "9223372036854775807");
    return digits && fits ? std::string()
                          : "must be a whole number from 0 to 2^63 - 1, not " + text;
  };
  verb.add_option("--seed", seed, help)
      ->capture_default_str()
      ->check(CLI::Validator(whole, "WHOLE"));
}

void add_threads(CLI::App& verb, int& threads) {
  const int cores = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  const auto at_most_cores = [cores](std::string& text) {
    int wanted = 0;
    if (CLI::detail::lexical_cast(text, wanted) && wanted > cores) {
      fmt::print(stderr, "note: --threads {}: this machine has {}, which are used\n", wanted,
                 cores);
      text = std::to_string(cores);
    }
    return std::string();
  };
  verb.add_option("--threads", threads, "0: all cores; the result does not depend on it")
      ->capture_default_str()
      ->transform(CLI::Validator(at_most_cores, ""))
      ->check(CLI::Range(0, 4096));
}

void add_json(CLI::App& verb, bool& json) {
  verb.add_flag("--json", json, "One JSON document on stdout");
}

CLI::Validator number_between(double low, double high) {
  const auto inside = [low, high](const std::string& text) {
    double value = NAN;
    const bool number = CLI::detail::lexical_cast(text, value);
    return number && value >= low && value <= high
               ? std::string()
               : fmt::format("must be a number from {} to {}, not {}", low, high, text);
  };
  return CLI::Validator(inside, fmt::format("[{} to {}]", low, high));
}

void print_json(const Json& json) {
  std::cout << json.dump(-1, ' ', false, Json::error_handler_t::replace) << std::endl;
}

std::string number_or(const char* otherwise, const char* format, double x) {
  return std::isfinite(x) ? fmt::format(fmt::runtime(format), x) : std::string(otherwise);
}

void watch_for_interrupt() {
  struct sigaction action {};
  struct sigaction before {};
  action.sa_handler = on_interrupt;
  sigemptyset(&action.sa_mask);
  for (const int which : kEndings) {
    sigaction(which, nullptr, &before);
    const bool job = which == SIGHUP || which == SIGQUIT;
    if (job && before.sa_handler == SIG_IGN) continue;  // nohup
    sigaction(which, &action, nullptr);
  }
  // A reader that went away, and a file beyond the limit, are errors of writing.
  ::signal(SIGPIPE, SIG_IGN);
  ::signal(SIGXFSZ, SIG_IGN);
}

bool interrupted() noexcept {
  return g_interrupted != 0;
}

const char* stopped_by() noexcept {
  const int which = g_interrupted;
  return which == SIGTERM   ? "SIGTERM"
         : which == SIGHUP  ? "SIGHUP (the terminal was closed)"
         : which == SIGQUIT ? "SIGQUIT"
                            : "Ctrl-C";
}

void stop_watching_for_interrupt() {
  struct sigaction now {};
  for (const int which : kEndings) {
    sigaction(which, nullptr, &now);
    if (now.sa_handler == on_interrupt) ::signal(which, SIG_DFL);
  }
}

struct Progress::State {
  using Clock = std::chrono::steady_clock;
  std::string what;
  std::size_t total;
  bool shown = ::isatty(STDERR_FILENO);
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

void Progress::operator()(std::size_t done, const std::string& note) {
  State& s = *state_;
  if (!s.shown) return;
  const std::lock_guard lock(s.mutex);
  const auto now = State::Clock::now();
  if (done < s.total && now - s.last < std::chrono::milliseconds(100)) return;
  s.last = now;
  const double seconds = std::chrono::duration<double>(now - s.begin).count();
  const double rate = static_cast<double>(done) / std::max(seconds, 1e-9);
  const auto filled = 30 * done / std::max<std::size_t>(1, s.total);
  fmt::print(stderr, "\r\033[K{} [{}{}] {}/{}  {:.3g}/s  {:.0f} s left{}", s.what,
             std::string(filled, '#'), std::string(30 - filled, ' '), done, s.total, rate,
             static_cast<double>(s.total - done) / rate, note);
}

std::vector<double> parse_range(const std::string& text, const std::string& option) {
  std::vector<std::string> parts(1);
  for (const char c : text)
    if (c == ':')
      parts.emplace_back();
    else
      parts.back() += c;
  if (parts.size() == 1) return {parse_number(parts[0], option)};
  if (parts.size() < 3 || parts.size() > 4 || (parts.size() == 4 && parts[3] != "log"))
    throw BadInput(option + " " + text + ": must be a number or from:to:count[:log]");
  const double from = parse_number(parts[0], option), to = parse_number(parts[1], option);
  const double count = parse_number(parts[2], option);
  if (count != std::floor(count) || count < 1 || count > 1e6)
    throw BadInput(option + " " + text + ": the count must be a whole number from 1 to 1000000");
  const bool logarithmic = parts.size() == 4;
  if (logarithmic && !(from > 0 && to > 0))
    throw BadInput(option + " " + text + ": both ends of a logarithmic range must be positive");
  const auto n = static_cast<std::size_t>(count);
  std::vector<double> values(n, from);
  for (std::size_t i = 1; i < n; ++i) {
    const double part = static_cast<double>(i) / static_cast<double>(n - 1);
    values[i] = logarithmic ? from * std::pow(to / from, part) : from + part * (to - from);
  }
  if (n > 1) values.back() = to;
  return values;
}

}  // namespace ferrule
