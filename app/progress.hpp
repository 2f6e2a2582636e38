// How far long work is.
#pragma once

#include <memory>
#include <string>

namespace ferrule {

// Progress of long work on a terminal: a bar with rate and time left; elsewhere nothing, or where
// the environment says FERRULE_PROGRESS=lines, lines "progress DONE OF" on stderr.
class Progress {
 public:
  Progress(std::string what, std::size_t total);
  ~Progress();
  // From any thread. `total`: where it is not the one that was said before; 0: as it was.
  void operator()(std::size_t done, const std::string& note = "", std::size_t total = 0);

 private:
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace ferrule
