#include "sim/base/file_system.hpp"

#include <fcntl.h>
#include <sys/file.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "sim/base/error.hpp"

namespace ferrule {
namespace {

// Of a call that the file system, or the kernel, does not have.
bool lacking(int error) noexcept {
  return error == ENOSYS || error == EOPNOTSUPP || error == EINVAL;
}

}  // namespace

FileLock lock_file(int fd, const std::string& file, bool wait) {
  for (;;) {
    if (::flock(fd, LOCK_EX | (wait ? 0 : LOCK_NB)) == 0) return FileLock::ours;
    if (errno == EINTR) continue;
    if (errno == EWOULDBLOCK) return FileLock::others;
    if (lacking(errno) || errno == ENOLCK) return FileLock::none;
    throw FileTrouble(file + ": cannot be locked: " + std::strerror(errno));
  }
}

int sync_file(int fd, int (*sync)(int)) noexcept {
  while (sync(fd) != 0) {
    if (errno == EINTR) continue;
    return lacking(errno) || errno == EROFS ? 0 : errno;
  }
  return 0;
}

int rename_unless_there(const std::string& from, const std::string& to) noexcept {
  const auto no_links = [] { return lacking(errno) || errno == EPERM || errno == EMLINK; };
  if (::link(from.c_str(), to.c_str()) == 0) {
    ::unlink(from.c_str());
    return 0;
  }
  if (!no_links()) return errno;
  if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return 0;
  if (!no_links()) return errno;
  const int taken = ::open(to.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (taken < 0) return errno;
  ::close(taken);
  if (::rename(from.c_str(), to.c_str()) == 0) return 0;
  const int error = errno;
  ::unlink(to.c_str());
  return error;
}

}  // namespace ferrule
