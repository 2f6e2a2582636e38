#include "capture/child.hpp"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <utility>

#include "sim/base/json_fields.hpp"

namespace ferrule {
namespace {

// What a child sends first.
enum Answer : char { kDone = 'D', kBadInput = 'B', kFileTrouble = 'F' };

void run(int fd, const std::function<void(Child::Parent&)>& work) {
  be_quiet();
  only_read_files();
  Child::Parent sender(fd);
  try {
    Child::Parent::allow(0, 0);
    work(sender);
  } catch (const BadInput& error) {
    sender.refuse(kBadInput, error.what());
  } catch (const FileTrouble& error) {
    sender.refuse(kFileTrouble, error.what());
  }  // what else is thrown, out of memory and what nobody foresaw, ends the child
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
  limit_memory(kMemory + memory);
  limit_time(kTime + time);
}

Child::Child(std::string file, const std::function<void(Parent&)>& work) : file_(std::move(file)) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0)
    throw FileTrouble(file_ + ": cannot be read: " + std::strerror(errno));
  fd_ = ends[0];
  try {
    process_.emplace(std::vector{ends[1]}, [&] { run(ends[1], work); });
  } catch (const FileTrouble& error) {
    ::close(ends[0]);
    ::close(ends[1]);
    throw FileTrouble(file_ + ": cannot be read: " + error.what());
  }
  ::close(ends[1]);
  try {
    first_answer();
  } catch (...) {
    ::close(fd_);
    throw;
  }
}

void Child::first_answer() {
  char answer = 0;
  if (take(&answer, 1) == 0) damaged();
  if (answer == kDone) return;
  std::string why(1 << 16, '\0');
  why.resize(take(why.data(), why.size()));
  if (answer == kBadInput) throw BadInput(why);
  throw FileTrouble(why);
}

Child::~Child() {
  ::close(fd_);
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
  if (take(data, size) != size) damaged();
}

void Child::damaged() {
  throw FileTrouble(file_ + ": damaged: " + ended(process_->wait()));
}

}  // namespace ferrule
