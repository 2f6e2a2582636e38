#include "app/keys.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <termios.h>
#include <unistd.h>

#include <cstring>

#include "app/interrupt.hpp"

namespace ferrule {
namespace {

termios g_before;
volatile sig_atomic_t g_changed = 0;

}  // namespace

void restore_terminal() noexcept {
  if (g_changed) ::tcsetattr(STDIN_FILENO, TCSANOW, &g_before);
}

Keys::Keys() noexcept
    : there_(::isatty(STDIN_FILENO) && ::isatty(STDERR_FILENO) &&
             ::tcgetattr(STDIN_FILENO, &g_before) == 0) {
  if (!there_) return;
  termios one_by_one = g_before;
  one_by_one.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  g_changed = 1;
  ::tcsetattr(STDIN_FILENO, TCSANOW, &one_by_one);
}

Keys::~Keys() {
  restore_terminal();
  g_changed = 0;
}

char Keys::pressed() noexcept {
  pollfd input{STDIN_FILENO, POLLIN, 0};
  char key = 0;
  if (!there_ || ::poll(&input, 1, 0) <= 0) return 0;
  if (::read(STDIN_FILENO, &key, 1) != 1) there_ = false;
  return key;
}

char Keys::ask(const std::string& question, const char* wanted,
               const std::function<void()>& meanwhile) {
  constexpr int kBetween = 10;  // [ms]
  ::tcflush(STDIN_FILENO, TCIFLUSH);
  fmt::print(stderr, "{}\n", question);
  while (there_ && !interrupted()) {
    pollfd input{STDIN_FILENO, POLLIN, 0};
    ::poll(&input, 1, kBetween);
    meanwhile();
    if (const char key = pressed(); key && std::strchr(wanted, key)) return key;
  }
  return 0;
}

}  // namespace ferrule
