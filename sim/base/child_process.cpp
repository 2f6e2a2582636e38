#include "sim/base/child_process.hpp"

#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/landlock.h>
#include <linux/seccomp.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/signalfd.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <utility>

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

// Every process whose parent this one is. Whether the kernel lists them.
bool kill_children() noexcept {
  char name[48], list[4096];
  std::snprintf(name, sizeof name, "/proc/self/task/%d/children", static_cast<int>(::getpid()));
  const int file = ::open(name, O_RDONLY | O_CLOEXEC);
  if (file < 0) return false;
  list[std::max<ssize_t>(::read(file, list, sizeof list - 1), 0)] = '\0';
  ::close(file);
  char* at = list;
  for (long process; (process = std::strtol(at, &at, 10)) > 0;)
    if (*at == ' ') ::kill(static_cast<pid_t>(process), SIGKILL);  // a number that is whole
  return true;
}

// Takes leave of those that have ended, and notes how `child` did. Whether there are others.
bool reap(pid_t child, std::optional<int>& status) noexcept {
  int how = 0;
  pid_t ended;
  while ((ended = ::waitpid(-1, &how, WNOHANG)) > 0)
    if (ended == child) status = how;
  return ended == 0;
}

// All that is below this process, of which `child` is the first. What hangs in the kernel is not
// waited for any longer than some seconds.
void end_all(pid_t child, std::optional<int>& status) noexcept {
  for (int i = 0; i < 5000 && reap(child, status); ++i) {
    if (!kill_children()) ::kill(0, SIGKILL);
    ::usleep(1000);
  }
}

// The guard: waits for the end of the child, and ends alike; or for that of the program, or until
// `stop` is closed. It leads the group, and whatever the child has started is below it, in other
// groups and sessions too: what loses its parent becomes the guard's.
[[noreturn]] void guard(int program, int stop, const std::vector<int>& keep,
                        const std::function<void()>& work) {
  ::setpgid(0, 0);
  forget_signals();
  ::prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0);
  const pid_t child = ::fork();
  if (child == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    close_files(STDERR_FILENO + 1, keep);
    run(work);
  }
  if (child < 0) ::_exit(1);
  sigset_t ends;
  sigemptyset(&ends);
  sigaddset(&ends, SIGCHLD);
  ::sigprocmask(SIG_BLOCK, &ends, nullptr);
  std::vector<int> own = {stop};
  if (program >= 0) own.insert(program < stop ? own.begin() : own.end(), program);
  close_files(0, own);
  const int ended = ::signalfd(-1, &ends, SFD_NONBLOCK);
  pollfd all[] = {{stop, POLLIN, 0}, {program, POLLIN, 0}, {ended, POLLIN, 0}};  // -1: passed over
  std::optional<int> status;
  for (;;) {
    reap(child, status);
    if (status || all[0].revents || all[1].revents) break;
    ::poll(all, 3, ended < 0 ? 10 : -1);
    signalfd_siginfo which;
    while (ended >= 0 && ::read(ended, &which, sizeof which) > 0) {
    }
  }
  end_all(child, status);
  const int how = status.value_or(SIGKILL);
  if (WIFSIGNALED(how)) {
    const rlimit none{};
    ::setrlimit(RLIMIT_CORE, &none);
    ::raise(WTERMSIG(how));
  }
  ::_exit(WEXITSTATUS(how));
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
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0)
    throw FileTrouble(std::string("no process can be started: ") + std::strerror(errno));
  const int program = open_process(::getpid());
  guard_ = ::fork();
  if (guard_ == 0) {
    ::close(ends[1]);
    guard(program, ends[0], keep, work);
  }
  const int error = errno;
  if (program >= 0) ::close(program);
  ::close(ends[0]);
  stop_ = ends[1];
  if (guard_ > 0) {
    ::setpgid(guard_, guard_);  // whoever of the two comes first
    return;
  }
  ::close(stop_);
  throw FileTrouble(std::string("no process can be started: ") + std::strerror(error));
}

ChildProcess::~ChildProcess() {
  if (status_) return;
  ::close(std::exchange(stop_, -1));
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
  ::kill(-guard_, SIGKILL);  // had it left any, while the guard's number is still its own
  int status = 0;
  while (::waitpid(guard_, &status, 0) < 0 && errno == EINTR) {
  }
  if (stop_ >= 0) ::close(std::exchange(stop_, -1));
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

namespace {

// What changes rights, owners, times and attributes of files, for which Landlock has no rule; what
// truncates them, for which it has one since Linux 6.2; and what would go around this list.
constexpr int kChanging[] = {
#ifdef SYS_chmod  // x86-64; other machines never had these
    SYS_chmod,
    SYS_chown,
    SYS_lchown,
    SYS_utime,
    SYS_utimes,
    SYS_futimesat,
#endif
    SYS_fchmod,
    SYS_fchmodat,
    SYS_fchown,
    SYS_fchownat,
    SYS_utimensat,
    SYS_setxattr,
    SYS_lsetxattr,
    SYS_fsetxattr,
    SYS_removexattr,
    SYS_lremovexattr,
    SYS_fremovexattr,
    SYS_truncate,
    437,  // openat2, whose flags a filter does not see
    SYS_io_uring_setup,
    452,  // fchmodat2
    463,  // setxattrat
    466,  // removexattrat
    469,  // file_setattr
};

// Where the flags of a call that opens are.
struct Opening {
  int call;
  std::size_t flags;
};
constexpr Opening kOpening[] = {
#ifdef SYS_open
    {SYS_open, offsetof(seccomp_data, args) + sizeof(__u64)},
#endif
    {SYS_openat, offsetof(seccomp_data, args) + 2 * sizeof(__u64)},
};

#if defined(__x86_64__)
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_AARCH64;
#else
constexpr std::uint32_t kArchitecture = 0;  // no filter
#endif

// From here on kChanging, O_TRUNC, and calls by the numbers of another architecture fail.
void refuse_changes() noexcept {
  if (kArchitecture == 0) return;
  constexpr std::uint32_t kForeign = 0x40000000;  // x32
  constexpr std::size_t kSize = 4 + std::size(kChanging) + 4 * std::size(kOpening) + 2;
  std::array<sock_filter, kSize> filter{};
  std::size_t n = 0;
  // To the last line where it is so.
  const auto refuse_if = [&](std::uint16_t how, std::uint32_t what) {
    const auto far = static_cast<std::uint8_t>(kSize - 2 - n);
    filter[n++] = BPF_JUMP(BPF_JMP | how | BPF_K, what, far, 0);
  };
  const auto load = [&](std::size_t from) {
    filter[n++] = BPF_STMT(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(from));
  };
  const auto answer = [&](std::uint32_t what) { filter[n++] = BPF_STMT(BPF_RET | BPF_K, what); };
  load(offsetof(seccomp_data, arch));
  filter[n] = BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, kArchitecture, 0,
                       static_cast<std::uint8_t>(kSize - 2 - n));
  ++n;
  load(offsetof(seccomp_data, nr));
  refuse_if(BPF_JGE, kForeign);
  for (const int call : kChanging) refuse_if(BPF_JEQ, static_cast<std::uint32_t>(call));
  for (const auto& [call, flags] : kOpening) {
    filter[n++] = BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(call), 0, 3);
    load(flags);
    refuse_if(BPF_JSET, O_TRUNC);
    answer(SECCOMP_RET_ALLOW);
  }
  answer(SECCOMP_RET_ALLOW);
  answer(SECCOMP_RET_ERRNO | EPERM);
  const sock_fprog program{static_cast<std::uint16_t>(kSize), filter.data()};
  ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program);
}

}  // namespace

void only_read_files() noexcept {
  constexpr __u64 kRefer = 1ULL << 13, kTruncate = 1ULL << 14;  // newer than some headers
  landlock_ruleset_attr none{};
  none.handled_access_fs =
      LANDLOCK_ACCESS_FS_EXECUTE | LANDLOCK_ACCESS_FS_WRITE_FILE | LANDLOCK_ACCESS_FS_REMOVE_DIR |
      LANDLOCK_ACCESS_FS_REMOVE_FILE | LANDLOCK_ACCESS_FS_MAKE_CHAR | LANDLOCK_ACCESS_FS_MAKE_DIR |
      LANDLOCK_ACCESS_FS_MAKE_REG | LANDLOCK_ACCESS_FS_MAKE_SOCK | LANDLOCK_ACCESS_FS_MAKE_FIFO |
      LANDLOCK_ACCESS_FS_MAKE_BLOCK | LANDLOCK_ACCESS_FS_MAKE_SYM;
  const long version =
      ::syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
  if (version >= 2) none.handled_access_fs |= kRefer;
  if (version >= 3) none.handled_access_fs |= kTruncate;
  const long rules = ::syscall(SYS_landlock_create_ruleset, &none, sizeof none, 0);
  ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  if (rules >= 0) {
    ::syscall(SYS_landlock_restrict_self, rules, 0);
    ::close(static_cast<int>(rules));
  }
  refuse_changes();
}

}  // namespace ferrule
