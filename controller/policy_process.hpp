// A process that is asked, and answers: JSON, a line each, in turns.
//
// What goes wrong is a std::runtime_error that says what: it ended, answered something else, or was
// silent for too long. It is good for nothing then. A PolicyKilled says nothing of it.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>

#include "sim/base/child_process.hpp"
#include "sim/base/json_fields.hpp"

namespace ferrule {

// It was killed from outside, as where memory is short, or could not be started.
struct PolicyKilled : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class PolicyProcess {
 public:
  // What it runs: it reads and writes `socket`, and says what is to be shown on `error`.
  using Work = std::function<void(int socket, int error)>;
  // Gets what it writes there, some bytes at a time, while it is asked and when it ends.
  using Said = std::function<void(const std::string&)>;
  // Whether it is waited for no longer; asked ten times a second.
  using Stop = std::function<bool()>;

  // Throws PolicyKilled where no process can be started.
  PolicyProcess(const Work& work, Said said, Stop stop);
  PolicyProcess(const PolicyProcess&) = delete;
  PolicyProcess& operator=(const PolicyProcess&) = delete;
  // Closes the socket, and kills what has not ended 0.2 s later.
  ~PolicyProcess();
  void close() noexcept;

  // The answer to `question` within `seconds`. One that says {"error": "why"} is an error too.
  Json ask(const Json& question, double seconds);

 private:
  using Clock = std::chrono::steady_clock;

  void wait(short events, Clock::time_point until, double seconds);
  void pass_on();
  [[noreturn]] void throw_how_it_ended();

  Said said_;
  Stop stop_;
  int fd_ = -1, error_ = -1;
  Clock::time_point closed_{};
  std::optional<ChildProcess> process_;
};

}  // namespace ferrule
