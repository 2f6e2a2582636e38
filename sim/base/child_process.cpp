#include "sim/base/child_process.hpp"

#include <fcntl.h>
#include <linux/landlock.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>

#include "sim/base/error.hpp"

namespace ferrule {
namespace {

// Those from `from` on, but for `keep`, which is sorted. The usual ones one by one: what stands
// between a program and the kernel (a simulated device of a test) follows close(), not more.
void close_files(unsigned from, const std::vector<int>& keep) noexcept {
  constexpr unsigned kUsual = 256;
  const auto close_until = [&](unsigned end) {
    for (; from < std::min(end, kUsual); ++from) ::close(static_cast<int>(from));
    if (from < end) ::close_range(from, end - 1, 0);
    from = std::max(from, end + 1);
  };
  for (const int fd : keep) close_until(static_cast<unsigned>(fd));
  close_until(~0U);
}

void forget_signals() noexcept {
  for (int which = 1; which < NSIG; ++which) ::signal(which, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
}

// Readable once it has ended; -1 without.
int open_process(pid_t process) noexcept {
  return static_cast<int>(::syscall(SYS_pidfd_open, process, 0));
}

[[noreturn]] void run(const std::function<void()>& work) {
  try {
    work();
  } catch (...) {
    ::_exit(1);
  }
  ::_exit(0);
}

// The guard: waits for the end of the child, and ends alike; or for that of the program, and kills
// the group that it leads.
[[noreturn]] void guard(int program, const std::vector<int>& keep,
                        const std::function<void()>& work) {
  ::setpgid(0, 0);
  forget_signals();
  const pid_t child = ::fork();
  if (child == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    close_files(STDERR_FILENO + 1, keep);
    run(work);
  }
  if (child < 0) ::_exit(1);
  close_files(0, {program});
  pollfd ends[] = {{program, POLLIN, 0}, {open_process(child), POLLIN, 0}};
  if (ends[0].fd >= 0 && ends[1].fd >= 0) {  // a kernel that has them
    while (::poll(ends, 2, -1) < 0 && errno == EINTR) {
    }
    if (!ends[1].revents) ::kill(0, SIGKILL);
  }
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFSIGNALED(status)) {
    const rlimit none{};
    ::setrlimit(RLIMIT_CORE, &none);
    ::raise(WTERMSIG(status));
  }
  ::_exit(WEXITSTATUS(status));
}

// Of the address space [bytes].
std::size_t memory_now() {
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

void limit(__rlimit_resource what, rlim_t most) noexcept {
  rlimit now{};
  if (::getrlimit(what, &now) != 0) return;
  now.rlim_cur = std::min(most, now.rlim_max);
  ::setrlimit(what, &now);
}

}  // namespace

ChildProcess::ChildProcess(std::vector<int> keep, const std::function<void()>& work) {
  std::sort(keep.begin(), keep.end());
  const int program = open_process(::getpid());
  guard_ = ::fork();
  if (guard_ == 0) guard(program, keep, work);
  const int error = errno;
  if (program >= 0) ::close(program);
  if (guard_ < 0)
    throw FileTrouble(std::string("no process can be started: ") + std::strerror(error));
  ::setpgid(guard_, guard_);  // whoever of the two comes first
}

ChildProcess::~ChildProcess() {
  if (status_) return;
  ::kill(-guard_, SIGKILL);
  wait();
}

std::optional<int> ChildProcess::ended() noexcept {
  siginfo_t info{};
  if (!status_ &&
      ::waitid(P_PID, static_cast<id_t>(guard_), &info, WEXITED | WNOHANG | WNOWAIT) == 0 &&
      info.si_pid != 0)
    wait();
  return status_;
}

int ChildProcess::wait() noexcept {
  if (status_) return *status_;
  siginfo_t info{};
  while (::waitid(P_PID, static_cast<id_t>(guard_), &info, WEXITED | WNOWAIT) < 0 &&
         errno == EINTR) {
  }
  ::kill(-guard_, SIGKILL);  // what it started, while the guard's number is still its own
  int status = 0;
  while (::waitpid(guard_, &status, 0) < 0 && errno == EINTR) {
  }
  status_ = status;
  return status;
}

void execute(const std::vector<std::string>& words, int in, int out, int error) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const int files[] = {in, out, error};
  for (int fd = 0; fd < 3; ++fd)
    ::dup2(files[fd] < 0 ? ::open("/dev/null", O_RDWR) : files[fd], fd);
  ::execvp(arguments[0], arguments.data());
  ::_exit(127);
}

void be_quiet() noexcept {
  ::signal(SIGPIPE, SIG_IGN);
  limit(RLIMIT_CORE, 0);
  if (const int nowhere = ::open("/dev/null", O_WRONLY); nowhere >= 0)
    ::dup2(nowhere, STDERR_FILENO);
}

void limit_memory(std::size_t more) noexcept {
  limit(RLIMIT_AS, memory_now() + more);
}

void limit_time(std::size_t seconds) noexcept {
  limit(RLIMIT_CPU, seconds);
}

void only_read_files() noexcept {
  landlock_ruleset_attr none{};
  none.handled_access_fs =
      LANDLOCK_ACCESS_FS_EXECUTE | LANDLOCK_ACCESS_FS_WRITE_FILE | LANDLOCK_ACCESS_FS_REMOVE_DIR |
      LANDLOCK_ACCESS_FS_REMOVE_FILE | LANDLOCK_ACCESS_FS_MAKE_CHAR | LANDLOCK_ACCESS_FS_MAKE_DIR |
      LANDLOCK_ACCESS_FS_MAKE_REG | LANDLOCK_ACCESS_FS_MAKE_SOCK | LANDLOCK_ACCESS_FS_MAKE_FIFO |
      LANDLOCK_ACCESS_FS_MAKE_BLOCK | LANDLOCK_ACCESS_FS_MAKE_SYM;
  const long rules = ::syscall(SYS_landlock_create_ruleset, &none, sizeof none, 0);
  if (rules < 0) return;
  ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  ::syscall(SYS_landlock_restrict_self, rules, 0);
  ::close(static_cast<int>(rules));
}

}  // namespace ferrule
