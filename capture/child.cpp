#include "capture/child.hpp"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <utility>

namespace ferrule {
namespace {

// What a child sends before each piece.
enum Answer : char { kPiece = 'P', kBadInput = 'B', kFileTrouble = 'F' };

void run(int fd, Child::Work kind, const std::function<void(Child::Parent&)>& work) {
  be_quiet();
  Child::Parent sender(fd);
  try {
    if (kind == Child::Work::reads) {
      only_read_files();
      Child::Parent::allow(0, 0);
    } else {
      ::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is an error of write()
    }
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
  const char piece = kPiece;
  if (write_all(fd_, &piece, 1) || write_all(fd_, static_cast<const char*>(data), size)) ::_exit(1);
}

void Child::Parent::send_json(const Json& json) noexcept {
  const auto bytes = Json::to_cbor(json);
  const std::uint64_t size = bytes.size();
  send(&size, sizeof size);
  send(bytes.data(), bytes.size());
}

void Child::Parent::refuse(char answer, const std::string& why) noexcept {
  if (write_all(fd_, &answer, 1) || write_all(fd_, why.data(), why.size())) ::_exit(1);
}

void Child::Parent::allow(std::size_t memory, std::size_t time) noexcept {
  limit_memory(kMemory + memory);
  limit_time(kTime + time);
}

Child::Child(std::string file, Work kind, const std::function<void(Parent&)>& work)
    : file_(std::move(file)), kind_(kind) {
  const auto trouble = [&](const char* why) {
    return FileTrouble(file_ + ": cannot be " + (kind_ == Work::reads ? "read: " : "written: ") +
                       why);
  };
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) throw trouble(std::strerror(errno));
  fd_ = ends[0];
  try {
    process_.emplace(std::vector{ends[1]}, [&] { run(ends[1], kind, work); });
  } catch (const FileTrouble& error) {
    ::close(ends[0]);
    ::close(ends[1]);
    throw trouble(error.what());
  }
  ::close(ends[1]);
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
  char answer = 0;
  if (take(&answer, 1) == 0) broken();
  if (answer == kPiece) {
    if (take(data, size) != size) broken();
    return;
  }
  std::string why(1 << 16, '\0');
  why.resize(take(why.data(), why.size()));
  if (answer == kBadInput) throw BadInput(why);
  throw FileTrouble(why);
}

Json Child::receive_json() {
  std::uint64_t size = 0;
  receive(&size, sizeof size);
  constexpr std::uint64_t kMost = 64 << 20;  // whatever a stranger's file made of the child
  std::vector<std::uint8_t> bytes(std::min(size, kMost));
  receive(bytes.data(), bytes.size());
  Json json = Json::from_cbor(bytes, true, false);
  if (json.is_discarded()) throw FileTrouble(file_ + ": damaged: reading it fails");
  return json;
}

void Child::broken() {
  const int status = process_->wait();
  if (kind_ == Work::writes) throw FileTrouble(file_ + ": cannot be written: writing it fails");
  throw FileTrouble(file_ + ": damaged: " + ended(status));
}

}  // namespace ferrule
