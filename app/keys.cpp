#include "app/keys.hpp"

#include <poll.h>
#include <unistd.h>

#include <cstring>

#include "app/verb.hpp"

namespace ferrule {

Keys::Keys() noexcept
    : there_(::isatty(STDIN_FILENO) && ::isatty(STDERR_FILENO) &&
             ::tcgetattr(STDIN_FILENO, &before_) == 0) {
  if (!there_) return;
  termios one_by_one = before_;
  one_by_one.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  ::tcsetattr(STDIN_FILENO, TCSANOW, &one_by_one);
}

Keys::~Keys() {
  if (there_) ::tcsetattr(STDIN_FILENO, TCSANOW, &before_);
}

char Keys::pressed() noexcept {
  pollfd input{STDIN_FILENO, POLLIN, 0};
  char key = 0;
  if (!there_ || ::poll(&input, 1, 0) <= 0) return 0;
  if (::read(STDIN_FILENO, &key, 1) != 1) there_ = false;
  return key;
}

char Keys::wait_for(const char* wanted) noexcept {
  constexpr int kBetween = 50;  // looks for Ctrl-C [ms]
  ::tcflush(STDIN_FILENO, TCIFLUSH);
  while (there_ && !interrupted()) {
    pollfd input{STDIN_FILENO, POLLIN, 0};
    ::poll(&input, 1, kBetween);
    if (const char key = pressed(); key && std::strchr(wanted, key)) return key;
  }
  return 0;
}

}  // namespace ferrule
