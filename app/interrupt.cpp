#include "app/interrupt.hpp"

#include <poll.h>
#include <signal.h>
#include <sys/time.h>
#include <unistd.h>

#include <atomic>
#include <string_view>

#include "app/keys.hpp"
#include "app/verbs.hpp"
#include "sim/base/json_fields.hpp"

namespace ferrule {
namespace {

// Ctrl-C, kill, a terminal that was closed, Ctrl-backslash.
constexpr int kEndings[] = {SIGINT, SIGTERM, SIGHUP, SIGQUIT};

std::atomic<int> g_interrupted = 0;                    // the signal
std::atomic<const char*> g_after = nullptr;            // of the EndsAfter that lives
static_assert(std::atomic<int>::is_always_lock_free);  // for the signal handler
static_assert(std::atomic<const char*>::is_always_lock_free);

[[noreturn]] void end_at_once() {
  restore_terminal();
  ::_exit(kInterrupted);
}

// In a signal handler: unless that would wait for a reader.
void say_at_once(std::string_view text) {
  pollfd error{STDERR_FILENO, POLLOUT, 0};
  if (::poll(&error, 1, 0) == 1 && (error.revents & POLLOUT))
    write_all(STDERR_FILENO, text.data(), text.size());
}

constexpr itimerval kPatience = {{}, {0, 800000}}, kNoAlarm = {};

void on_interrupt(int which) {
  if (g_interrupted) end_at_once();
  if (const char* const what = g_after) {
    for (const char* part :
         {"ferrule: stops after this ", what, "; another signal ends it at once\n"})
      say_at_once(part);
  } else {
    ::setitimer(ITIMER_REAL, &kPatience, nullptr);
  }
  g_interrupted = which;
}

// No verb has asked interrupted() in the meantime.
void on_alarm(int) {
  say_at_once("ferrule: stopped before the end: nothing more of it is kept\n");
  end_at_once();
}

}  // namespace

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
  action.sa_handler = on_alarm;
  sigaction(SIGALRM, &action, nullptr);
  // A reader that went away, and a file beyond the limit, are errors of writing.
  ::signal(SIGPIPE, SIG_IGN);
  ::signal(SIGXFSZ, SIG_IGN);
}

bool interrupted() noexcept {
  if (!g_interrupted) return false;
  ::setitimer(ITIMER_REAL, &kNoAlarm, nullptr);
  return true;
}

EndsAfter::EndsAfter(const char* what) noexcept : before_(g_after.exchange(what)) {}

EndsAfter::~EndsAfter() {
  g_after = before_;
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
  ::setitimer(ITIMER_REAL, &kNoAlarm, nullptr);
}

void end_if_interrupted() {
  if (interrupted()) throw Stopped();
}

}  // namespace ferrule
