// Single keys from the terminal, without Enter, while this lives. Ctrl-C stays what it is.
#pragma once

#include <functional>
#include <string>

namespace ferrule {

class Keys {
 public:
  Keys() noexcept;
  ~Keys();
  Keys(const Keys&) = delete;
  Keys& operator=(const Keys&) = delete;

  // Whether somebody sits at a terminal: stdin and stderr are one.
  bool there() const noexcept { return there_; }
  // The key that was pressed since, '\0' if none was.
  char pressed() noexcept;
  // Forgets what was pressed so far, asks on stderr, and waits until one of `wanted` is pressed,
  // doing `meanwhile` now and then; '\0' at Ctrl-C or when the terminal is gone. What `meanwhile`
  // throws ends it.
  char ask(
      const std::string& question, const char* wanted,
      const std::function<void()>& meanwhile = [] {});

 private:
  bool there_;
};

// The terminal as it was before any Keys; for ends without destructors. Safe in a signal handler.
void restore_terminal() noexcept;

}  // namespace ferrule
