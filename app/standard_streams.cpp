#include "app/standard_streams.hpp"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>

#include "sim/base/json_fields.hpp"

namespace ferrule {
namespace {

// Without the SIGPIPE of a reader that went away.
ssize_t write_or_forget(void*, const char* bytes, std::size_t size) {
  sigset_t pipe, before, pending;
  sigemptyset(&pipe);
  sigaddset(&pipe, SIGPIPE);
  sigpending(&pending);
  pthread_sigmask(SIG_BLOCK, &pipe, &before);
  const int error = write_all(STDERR_FILENO, bytes, size);
  const timespec at_once{};
  if (error == EPIPE && !sigismember(&pending, SIGPIPE)) sigtimedwait(&pipe, nullptr, &at_once);
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  return static_cast<ssize_t>(size);
}

}  // namespace

void secure_standard_streams() {
  for (const int fd : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (::fcntl(fd, F_GETFD) < 0 && errno == EBADF)
      ::open("/dev/null", fd == STDERR_FILENO ? O_WRONLY : O_RDONLY);
  if (FILE* const file =
          ::fopencookie(nullptr, "w", {nullptr, write_or_forget, nullptr, nullptr})) {
    std::setvbuf(file, nullptr, _IONBF, 0);
    stderr = file;
  }
}

MutedOutput::MutedOutput() : before_((std::fflush(stdout), ::dup(STDOUT_FILENO))) {
  const int nothing = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  ::dup2(nothing, STDOUT_FILENO);
  ::close(nothing);
}

MutedOutput::~MutedOutput() {
  std::fflush(stdout);
  ::dup2(before_, STDOUT_FILENO);
  ::close(before_);
}

}  // namespace ferrule
