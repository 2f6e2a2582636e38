#include "controller/policy_process.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <iterator>
#include <thread>
#include <utility>

namespace ferrule {
namespace {

constexpr std::size_t kMostLine = 1 << 16;  // bytes of an answer
constexpr std::size_t kMostShown = 80;      // of it in a message
constexpr std::chrono::milliseconds kLook(100), kGrace(200), kNap(10);

// What others send to a program, or the system where something is short; no mistake of its own.
bool from_outside(int signal) {
  constexpr int kSignals[] = {SIGKILL, SIGTERM, SIGINT, SIGHUP, SIGQUIT, SIGXCPU};
  return std::find(std::begin(kSignals), std::end(kSignals), signal) != std::end(kSignals);
}

}  // namespace

PolicyProcess::PolicyProcess(const Work& work, Said said, Stop stop)
    : said_(std::move(said)), stop_(std::move(stop)) {
  int ends[2], errors[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
    throw PolicyKilled(std::string("no pipe to the policy: ") + std::strerror(errno));
  fd_ = ends[0];
  const bool piped = ::pipe2(errors, O_CLOEXEC) == 0;
  const int trouble = errno;
  try {
    if (!piped) throw PolicyKilled(std::string("no pipe to the policy: ") + std::strerror(trouble));
    error_ = errors[0];
    ::fcntl(error_, F_SETFL, O_NONBLOCK);
    process_.emplace(std::vector{ends[1], errors[1]}, [&] { work(ends[1], errors[1]); });
  } catch (const std::exception& error) {
    for (const int fd : {ends[0], ends[1], piped ? errors[0] : -1, piped ? errors[1] : -1})
      ::close(fd);
    throw PolicyKilled(error.what());
  }
  ::close(ends[1]);
  ::close(errors[1]);
}

PolicyProcess::~PolicyProcess() {
  close();
  while (!process_->ended() && Clock::now() < closed_ + kGrace) std::this_thread::sleep_for(kNap);
  process_.reset();
  pass_on();
  ::close(error_);
}

void PolicyProcess::close() noexcept {
  if (fd_ < 0) return;
  ::close(std::exchange(fd_, -1));
  closed_ = Clock::now();
}

Json PolicyProcess::ask(const Json& question, double seconds) {
  const auto until = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                        std::chrono::duration<double>(seconds));
  const std::string line = question.dump() + "\n";
  for (std::size_t sent = 0; sent < line.size();) {
    wait(POLLOUT, until, seconds);
    const ssize_t n =
        ::send(fd_, line.data() + sent, line.size() - sent, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (n < 0 && errno != EAGAIN && errno != EINTR) throw_how_it_ended();
    if (n > 0) sent += static_cast<std::size_t>(n);
  }
  std::string answer;
  while (answer.empty() || answer.back() != '\n') {
    wait(POLLIN, until, seconds);
    char bytes[4096];
    const ssize_t n = ::recv(fd_, bytes, sizeof bytes, MSG_DONTWAIT);
    if (n == 0 || (n < 0 && errno != EAGAIN && errno != EINTR)) throw_how_it_ended();
    if (n > 0) answer.append(bytes, static_cast<std::size_t>(n));
    if (answer.size() > kMostLine)
      throw std::runtime_error("the policy answered a line of more than 65536 bytes");
  }
  answer.pop_back();
  if (answer.find('\n') != std::string::npos)
    throw std::runtime_error("the policy answered more than it was asked");
  Json json = Json::parse(answer, nullptr, false);
  if (json.is_discarded())
    throw std::runtime_error("the policy answered no JSON: " + printable(answer, kMostShown));
  if (json.is_object() && json.contains("error") && json["error"].is_string())
    throw std::runtime_error("the policy failed: " + printable(json["error"], 300));
  return json;
}

// Until the socket is ready for one of `events`; what is said meanwhile is passed on.
void PolicyProcess::wait(short events, Clock::time_point until, double seconds) {
  for (;;) {
    if (stop_ && stop_()) throw std::runtime_error("the policy was stopped");
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now());
    if (left.count() <= 0)
      throw std::runtime_error(fmt::format("the policy did not answer within {:g} s", seconds));
    pollfd both[] = {{fd_, events, 0}, {error_, POLLIN, 0}};
    ::poll(both, 2, static_cast<int>(std::min(left, kLook).count()));
    if (both[1].revents) pass_on();
    if (both[0].revents) return;
  }
}

void PolicyProcess::pass_on() {
  char bytes[4096];
  for (int most = 16; most > 0; --most) {  // as much as a pipe holds
    const ssize_t n = ::read(error_, bytes, sizeof bytes);
    if (n == 0) ::close(std::exchange(error_, -1));  // poll passes over -1
    if (n <= 0) return;
    if (said_) said_(std::string(bytes, static_cast<std::size_t>(n)));
  }
}

void PolicyProcess::throw_how_it_ended() {
  std::optional<int> status;
  for (const auto begin = Clock::now();
       !(status = process_->ended()) && Clock::now() < begin + kGrace;)
    std::this_thread::sleep_for(kNap);
  pass_on();
  if (!status) throw std::runtime_error("the policy closed its pipe");
  // The shell says of a program that a signal ended 128 and its number.
  const int signal = WIFSIGNALED(*status) ? WTERMSIG(*status) : WEXITSTATUS(*status) - 128;
  if (from_outside(signal)) throw PolicyKilled(fmt::format("signal {}", signal));
  throw std::runtime_error(
      WIFSIGNALED(*status) ? fmt::format("the policy ended (signal {})", signal)
                           : fmt::format("the policy ended (exit code {})", WEXITSTATUS(*status)));
}

}  // namespace ferrule
