// A child process that never outlives this program, and what it may take where strangers made what
// it works on.
//
// The child is in a process group of its own: Ctrl-C at a terminal reaches this program alone. A
// guard stands between the two. When the child ends, or is no longer wanted, or this program ends,
// by kill -9 too, the guard kills the child and all that it started in turn, also what has left
// the group by setpgid or setsid. Only what kills the guard first is out of its reach; on a
// kernel that does not list the children of a process (CONFIG_PROC_CHILDREN), also what has left
// the group.
#pragma once

#include <sys/types.h>

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace ferrule {

class ChildProcess {
 public:
  // Runs `work` in a fork of this process, which ends with exit code 0 when `work` returns, and
  // with 1 when it throws. No other thread is in the fork: `work` executes a program, or computes
  // by itself. Of the open files it has the standard ones and `keep`; no signal is blocked, ignored
  // or handled. Throws FileTrouble where no process can be started.
  ChildProcess(std::vector<int> keep, const std::function<void()>& work);
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;
  // Kills it with all that it started.
  ~ChildProcess();

  // Its status, as that of waitpid(); empty while it runs.
  std::optional<int> ended() noexcept;
  // The same once it has ended, and all that it started was killed.
  int wait() noexcept;

 private:
  pid_t guard_ = -1;  // leads the group; ends as the child did
  int stop_ = -1;     // closed: the guard kills the child
  std::optional<int> status_;
};

// For `work`: executes a program found on PATH with `in`, `out` and `error` as its standard files,
// -1: /dev/null. `words` begins with its name. Ends with exit code 127 where there is no such
// program.
[[noreturn]] void execute(const std::vector<std::string>& words, int in, int out, int error);

// For `work` on what strangers made. Crashes leave no core, and what libraries print goes nowhere.
void be_quiet() noexcept;
// Address space [bytes] beyond what it has now, and time of a processor [s] in all.
void limit_memory(std::size_t more) noexcept;
void limit_time(std::size_t seconds) noexcept;
// It opens no file to write, truncates, removes and executes none, where the kernel has Landlock,
// and changes neither rights nor owners, times and attributes of one, where this is x86-64 or
// AArch64.
void only_read_files() noexcept;

}  // namespace ferrule
