// A fit that runs beside the window: `ferrule fit` as a process of its own, of low priority, so
// that it never disturbs the loop. It ends with the thread that began it, by kill -9 too.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace ferrule {

class BackgroundFit {
 public:
  // Fits `episodes` (files) and writes the controller `out`. `program`: the file of ferrule. Throws
  // FileTrouble.
  BackgroundFit(const std::string& program, const std::vector<std::string>& episodes,
                const std::string& out);
  BackgroundFit(const BackgroundFit&) = delete;
  BackgroundFit& operator=(const BackgroundFit&) = delete;
  // Ends it.
  ~BackgroundFit();

  enum class State { running, done, failed };
  // How it is now; does not wait.
  State poll();
  // Of the part of the work that it is at, from 1 on: 0 to 1.
  double progress() const noexcept { return progress_; }
  int part() const noexcept { return part_; }
  const std::string& text() const noexcept { return last_line_; }  // what it said last, of why
  const std::string& controller() const noexcept { return out_; }

 private:
  void read_on();
  void take(const std::string& line);

  std::string out_, line_, last_line_;
  pid_t child_ = -1;
  int fd_ = -1;
  double progress_ = 0;
  int part_ = 1;
  State state_ = State::running;
};

}  // namespace ferrule
