#include "capture/child.hpp"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>
#include <utility>

#include "sim/scene/json_fields.hpp"

namespace ferrule {
namespace {

// What a child sends first.
enum Answer : char { kDone = 'D', kBadInput = 'B', kFileTrouble = 'F' };

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

// Crashes are quiet: the default actions, no core, and what libraries print goes nowhere.
void be_quiet() noexcept {
  for (const int crash : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGXCPU})
    ::signal(crash, SIG_DFL);
  ::signal(SIGPIPE, SIG_IGN);
  limit(RLIMIT_CORE, 0);
  if (const int nowhere = ::open("/dev/null", O_WRONLY); nowhere >= 0)
    ::dup2(nowhere, STDERR_FILENO);
}

[[noreturn]] void run(int fd, pid_t parent, const std::function<void(Child::Parent&)>& work) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(1);
  be_quiet();
  Child::Parent sender(fd);
  try {
    Child::Parent::allow(0, 0);
    work(sender);
  } catch (const BadInput& error) {
    sender.refuse(kBadInput, error.what());
  } catch (const FileTrouble& error) {
    sender.refuse(kFileTrouble, error.what());
  } catch (...) {  // out of memory, and what nobody foresaw
    ::_exit(1);
  }
  ::_exit(0);
}

// How a child ended that had not sent everything.
const char* ended(int status) {
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU) return "reading it takes too long";
  if (WIFSIGNALED(status)) return "reading it fails";
  return "reading it takes too much memory";
}

}  // namespace

void Child::Parent::send(const void* data, std::size_t size) noexcept {
  const char done = kDone;
  if (!std::exchange(began_, true) && write_all(fd_, &done, 1)) ::_exit(1);
  if (write_all(fd_, static_cast<const char*>(data), size)) ::_exit(1);
}

void Child::Parent::refuse(char answer, const std::string& why) noexcept {
  if (began_ || write_all(fd_, &answer, 1) || write_all(fd_, why.data(), why.size())) ::_exit(1);
}

void Child::Parent::allow(std::size_t memory, std::size_t time) noexcept {
  limit(RLIMIT_AS, memory_now() + kMemory + memory);
  limit(RLIMIT_CPU, kTime + time);
}

Child::Child(std::string file, const std::function<void(Parent&)>& work) : file_(std::move(file)) {
  int ends[2];
  const pid_t parent = ::getpid();
  if (::pipe2(ends, O_CLOEXEC) != 0)
    throw FileTrouble(file_ + ": cannot be read: " + std::strerror(errno));
  child_ = ::fork();
  if (child_ == 0) {
    ::close(ends[0]);
    run(ends[1], parent, work);
  }
  ::close(ends[1]);
  fd_ = ends[0];
  try {
    first_answer();
  } catch (...) {
    end();
    throw;
  }
}

void Child::first_answer() {
  char answer = 0;
  if (child_ < 0) throw FileTrouble(file_ + ": cannot be read: " + std::strerror(errno));
  if (take(&answer, 1) == 0) throw FileTrouble(file_ + ": damaged: " + ended(end()));
  if (answer == kDone) return;
  std::string why(1 << 16, '\0');
  why.resize(take(why.data(), why.size()));
  if (answer == kBadInput) throw BadInput(why);
  throw FileTrouble(why);
}

Child::~Child() {
  end();
}

int Child::end() noexcept {
  int status = 0;
  ::close(std::exchange(fd_, -1));
  const pid_t child = std::exchange(child_, -1);
  if (child > 0)
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
  return status;
}

std::size_t Child::take(void* data, std::size_t size) noexcept {
  std::size_t taken = 0;
  while (taken < size) {
    const ssize_t n = ::read(fd_, static_cast<char*>(data) + taken, size - taken);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    taken += static_cast<std::size_t>(n);
  }
  return taken;
}

void Child::receive(void* data, std::size_t size) {
  if (take(data, size) != size) throw FileTrouble(file_ + ": damaged: " + ended(end()));
}

}  // namespace ferrule
