#include "controller/program_policy.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <limits>
#include <mutex>
#include <stdexcept>
#include <thread>

#include "sim/error.hpp"
#include "sim/scene/json_fields.hpp"

namespace ferrule {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kMostLine = 1 << 16;  // bytes of an answer
constexpr std::size_t kMostShown = 80;      // of it in a message

// One process. What goes wrong is a std::runtime_error that says what.
class Peer {
 public:
  explicit Peer(const std::string& command) {
    int ends[2];
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
      throw std::runtime_error(std::string("no pipe to the policy: ") + std::strerror(errno));
    fd_ = ends[0];
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_adddup2(&files, ends[1], STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&files, ends[1], STDOUT_FILENO);
    posix_spawnattr_t how;
    posix_spawnattr_init(&how);  // a group of its own, which is ended as a whole
    posix_spawnattr_setflags(&how, POSIX_SPAWN_SETPGROUP);
    posix_spawnattr_setpgroup(&how, 0);
    std::string words[] = {"sh", "-c", command};
    char* arguments[] = {words[0].data(), words[1].data(), words[2].data(), nullptr};
    const int error = ::posix_spawn(&process_, "/bin/sh", &files, &how, arguments, environ);
    posix_spawnattr_destroy(&how);
    posix_spawn_file_actions_destroy(&files);
    ::close(ends[1]);
    if (error == 0) return;
    ::close(fd_);
    throw std::runtime_error(std::string("the policy cannot be run: ") + std::strerror(error));
  }
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;
  ~Peer() {
    ::close(fd_);
    int status = 0;
    for (int n = 0; n < 20 && ::waitpid(process_, &status, WNOHANG) == 0; ++n)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    ::kill(-process_, SIGKILL);
    ::waitpid(process_, &status, 0);
  }

  // The answer to `question` within `seconds`.
  Json ask(const Json& question, double seconds) {
    const auto until = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                          std::chrono::duration<double>(seconds));
    const std::string line = question.dump() + "\n";
    for (std::size_t sent = 0; sent < line.size();) {
      wait(POLLOUT, until, seconds);
      const ssize_t n =
          ::send(fd_, line.data() + sent, line.size() - sent, MSG_NOSIGNAL | MSG_DONTWAIT);
      if (n < 0 && errno != EAGAIN && errno != EINTR) throw std::runtime_error(ended());
      if (n > 0) sent += static_cast<std::size_t>(n);
    }
    std::string answer;
    while (answer.empty() || answer.back() != '\n') {
      wait(POLLIN, until, seconds);
      char bytes[4096];
      const ssize_t n = ::recv(fd_, bytes, sizeof bytes, MSG_DONTWAIT);
      if (n == 0 || (n < 0 && errno != EAGAIN && errno != EINTR)) throw std::runtime_error(ended());
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
    return json;
  }

 private:
  void wait(short events, Clock::time_point until, double seconds) const {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now()).count();
    pollfd one{fd_, events, 0};
    if (left <= 0 || ::poll(&one, 1, static_cast<int>(left)) == 0)
      throw std::runtime_error(fmt::format("the policy did not answer within {:g} s", seconds));
  }

  std::string ended() const {
    siginfo_t info{};
    for (int n = 0; n < 20 && info.si_pid == 0; ++n) {
      ::waitid(P_PID, static_cast<id_t>(process_), &info, WEXITED | WNOHANG | WNOWAIT);
      if (info.si_pid == 0) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    if (info.si_pid == 0) return "the policy closed its pipe";
    return fmt::format("the policy ended ({} {})",
                       info.si_code == CLD_EXITED ? "exit code" : "signal", info.si_status);
  }

  int fd_ = -1;
  pid_t process_ = -1;
};

// Those that wait for a trial.
struct Peers {
  ProgramSettings settings;
  std::mutex mutex;
  std::vector<std::unique_ptr<Peer>> free;

  std::unique_ptr<Peer> take() {
    {
      const std::lock_guard lock(mutex);
      if (!free.empty()) {
        std::unique_ptr<Peer> peer = std::move(free.back());
        free.pop_back();
        return peer;
      }
    }
    return std::make_unique<Peer>(settings.command);
  }
  void give_back(std::unique_ptr<Peer> peer) {
    const std::lock_guard lock(mutex);
    free.push_back(std::move(peer));
  }
};

HandTwist velocity_of(const Json& answer) {
  const bool there = answer.is_object() && answer.contains("velocity");
  const Json velocity = there ? answer["velocity"] : Json();
  HandTwist v;
  bool numbers = velocity.is_array() && velocity.size() == 5;
  for (std::size_t i = 0; numbers && i < 5; ++i) {
    numbers = velocity[i].is_number();
    if (numbers) v[static_cast<Eigen::Index>(i)] = velocity[i];
  }
  if (!numbers)
    throw std::runtime_error(R"(the policy answered no {"velocity": [5 numbers]}: )" +
                             printable(answer.dump(-1, ' ', true), kMostShown));
  return v;
}

class ProgramPolicy : public Controller {
 public:
  ProgramPolicy(std::shared_ptr<Peers> peers, std::uint64_t trial) : peers_(std::move(peers)) {
    const ProgramSettings& s = peers_->settings;
    guarded([&] {
      peer_ = peers_->take();
      const Json answer = peer_->ask(
          {{"reset", {{"trial", trial}, {"seed", s.seed}, {"control_hz", s.control_hz}}}},
          s.start_timeout);
      if (!answer.is_object())
        throw std::runtime_error("the policy answered a reset with no object: " +
                                 printable(answer.dump(-1, ' ', true), kMostShown));
    });
  }
  ~ProgramPolicy() override {
    if (peer_) peers_->give_back(std::move(peer_));
  }

  HandTwist command(const Observation& o) noexcept override {
    HandTwist v = HandTwist::Constant(std::numeric_limits<double>::quiet_NaN());
    if (!peer_) return v;
    guarded([&] {
      const Json wrench = std::vector<double>(o.wrench.begin(), o.wrench.end());
      v = velocity_of(peer_->ask({{"wrench", wrench}, {"depth", o.depth}, {"time", o.time}},
                                 peers_->settings.timeout));
    });
    return v;
  }
  std::string failure() const override { return failure_; }

 private:
  template <class Work>
  void guarded(const Work& work) noexcept {
    try {
      work();
    } catch (const std::exception& error) {
      failure_ = error.what();
      peer_.reset();
    }
  }

  std::shared_ptr<Peers> peers_;
  std::unique_ptr<Peer> peer_;  // null: it failed
  std::string failure_;
};

}  // namespace

MakeController program_policy(const ProgramSettings& settings) {
  const auto peers = std::make_shared<Peers>();
  peers->settings = settings;
  return [peers](std::uint64_t trial) { return std::make_unique<ProgramPolicy>(peers, trial); };
}

}  // namespace ferrule
