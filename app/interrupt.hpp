// How a person or another program ends a verb: Ctrl-C and other signals.
#pragma once

#include <string>

namespace ferrule {

// Ctrl-C, SIGTERM, Ctrl-backslash or a closed terminal: the first one asks the verb to end cleanly,
// and ends the program where the verb does not hear it within a second, by asking interrupted();
// the second ends the program at once.
void watch_for_interrupt();
bool interrupted() noexcept;  // from any thread
// While one of these lives, the first signal is heard at the end of a case (or a step, as `what`
// says), however long that takes, and says so: for verbs that keep what was done before.
class EndsAfter {
 public:
  explicit EndsAfter(const char* what) noexcept;
  ~EndsAfter();
  EndsAfter(const EndsAfter&) = delete;
  EndsAfter& operator=(const EndsAfter&) = delete;

 private:
  const char* before_;
};
// What ended it: "Ctrl-C", "SIGTERM" ...
const char* stopped_by() noexcept;
// Ctrl-C ends the program at once again.
void stop_watching_for_interrupt();

// For long work that is not worth anything unless it is whole: ends the verb where Ctrl-C asked for
// it, with exit code 130.
struct Stopped {
  std::string kept = "nothing of it is kept";
};
void end_if_interrupted();  // throws Stopped

}  // namespace ferrule
