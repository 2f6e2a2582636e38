#include "sim/base/written_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <utility>

#include "sim/base/file_system.hpp"
#include "sim/base/json_fields.hpp"

namespace ferrule {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kBeside = ".XXXXXX.tmp";  // of mkstemps
constexpr std::string_view kTemporary = ".tmp";

[[noreturn]] void cannot_write(const std::string& file, int error) {
  throw FileTrouble(file + ": cannot be written: " + std::strerror(error));
}

bool to_be_written_at_once(const std::string& name) {
  std::error_code ignored;
  const fs::file_status there = fs::status(name, ignored);
  return fs::exists(there) && !fs::is_regular_file(there);
}

// Makes a file beside `file` and locks it, so that nobody takes it for a leftover; -1 with errno.
int open_beside(std::string& beside, const std::string& file) {
  constexpr int kTries =
      100;  // somebody may remove it before it is locked, but not again and again
  for (int i = 0; i < kTries; ++i) {
    beside = file + std::string(kBeside);
    const int fd = ::mkstemps(beside.data(), static_cast<int>(kTemporary.size()));
    if (fd < 0) return fd;
    struct stat now {};
    try {
      if (lock_file(fd, beside, true) == FileLock::none) return fd;
    } catch (const FileTrouble&) {
      ::unlink(beside.c_str());
      ::close(fd);
      throw;
    }
    if (::fstat(fd, &now) == 0 && now.st_nlink > 0) return fd;
    ::close(fd);
  }
  errno = EBUSY;
  return -1;
}

}  // namespace

WrittenFile::WrittenFile(const std::string& name) : name_(name), file_(name) {
  std::error_code ignored;
  if (fs::is_directory(name, ignored)) throw FileTrouble(name + ": is a directory");
  if (to_be_written_at_once(name)) return;
  if (fs::is_symlink(fs::symlink_status(name, ignored)) && fs::exists(name, ignored))
    file_ = fs::canonical(name).string();
  const fs::path folder = fs::path(file_).parent_path();
  const std::string last = fs::path(file_).filename().string();
  remove_half_written(folder.empty() ? "." : folder.string(),
                      [&](const std::string& other) { return other == last; });
  fd_ = open_beside(beside_, file_);
  if (fd_ < 0) cannot_write(name, errno);
  const mode_t mask = ::umask(0);
  ::umask(mask);
  ::fchmod(fd_, 0666 & ~mask);
}

WrittenFile::WrittenFile(const std::string& name, std::string text) : WrittenFile(name) {
  text_ = std::move(text);
  if (fd_ < 0) return;
  if (const int error = write_all(fd_, text_.data(), text_.size())) cannot_write(name, error);
  keep();
}

const std::string& WrittenFile::path() const {
  if (fd_ < 0) throw FileTrouble(name_ + ": is a device or a pipe, not a file");
  return beside_;
}

void WrittenFile::keep() {
  if (const int error = sync_file(fd_)) cannot_write(name_, error);
}

WrittenFile::~WrittenFile() {
  if (fd_ < 0) return;
  ::unlink(beside_.c_str());
  ::close(fd_);
}

void WrittenFile::commit(bool replace) {
  if (fd_ < 0) {  // a pipe that nobody reads is an error and not a wait
    const int fd = ::open(name_.c_str(), O_WRONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0) cannot_write(name_, errno);
    ::fcntl(fd, F_SETFL, O_WRONLY);
    const int error = write_all(fd, text_.data(), text_.size());
    ::close(fd);
    if (error) cannot_write(name_, error);
    return;
  }
  if (!replace) {
    if (const int error = rename_unless_there(beside_, file_)) cannot_write(name_, error);
  } else if (::rename(beside_.c_str(), file_.c_str()) != 0) {
    cannot_write(name_, errno);
  }
  ::close(std::exchange(fd_, -1));
}

void remove_half_written(const std::string& folder,
                         const std::function<bool(const std::string& name)>& wanted) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string beside = entry.path().filename().string();
    if (!beside.ends_with(kTemporary) || beside.size() <= kBeside.size() ||
        beside[beside.size() - kBeside.size()] != '.' ||
        !wanted(beside.substr(0, beside.size() - kBeside.size())))
      continue;
    const int fd = ::open(entry.path().c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOFOLLOW);
    if (fd < 0) continue;
    try {
      if (lock_file(fd, beside) == FileLock::ours) ::unlink(entry.path().c_str());
    } catch (const FileTrouble&) {  // it stays
    }
    ::close(fd);
  }
}

}  // namespace ferrule
