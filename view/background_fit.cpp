#include "view/background_fit.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string_view>
#include <utility>

#include "sim/base/error.hpp"

extern char** environ;

namespace ferrule {
namespace {

constexpr int kNice = 10;  // behind the loop's, and not so far that other work leaves it nothing

// The environment, with lines of progress asked for.
std::vector<std::string> with_progress() {
  std::vector<std::string> all = {"FERRULE_PROGRESS=lines"};
  for (char** one = environ; *one; ++one) all.emplace_back(*one);
  return all;
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> all;
  for (std::string& text : texts) all.push_back(text.data());
  all.push_back(nullptr);
  return all;
}

}  // namespace

BackgroundFit::BackgroundFit(const std::string& program, const std::vector<std::string>& episodes,
                             const std::string& out)
    : out_(out) {
  std::vector<std::string> words = {program, "fit"};
  words.insert(words.end(), episodes.begin(), episodes.end());
  words.insert(words.end(), {"--out", out});
  std::vector<std::string> environment = with_progress();
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) throw FileTrouble(std::string("fit: ") + std::strerror(errno));
  fd_ = ends[0];
  ::fcntl(fd_, F_SETFL, O_NONBLOCK);
  const std::vector<char*> arguments = pointers(words), variables = pointers(environment);
  const pid_t parent = ::getpid();
  const int nothing = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  // Unlike fork() it copies no memory of this process, in which the loop may run.
  child_ = ::vfork();  // NOLINT(clang-analyzer-security.insecureAPI.vfork)
  if (child_ == 0) {
    ::setpgid(0, 0);  // Ctrl-C is for the window, which ends it
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) ::_exit(1);
    for (const auto& [from, to] : {std::pair(nothing, 0), {nothing, 1}, {ends[1], 2}})
      ::dup2(from, to);
    ::execve(program.c_str(), arguments.data(), variables.data());
    ::_exit(127);
  }
  ::close(nothing);
  ::close(ends[1]);
  if (child_ < 0) {
    ::close(fd_);
    throw FileTrouble(program + ": cannot be run: " + std::strerror(errno));
  }
  ::setpriority(PRIO_PROCESS, static_cast<id_t>(child_), kNice);
}

BackgroundFit::~BackgroundFit() {
  if (state_ == State::running) {
    ::kill(child_, SIGKILL);
    ::waitpid(child_, nullptr, 0);
  }
  ::close(fd_);
}

void BackgroundFit::take(const std::string& line) {
  double done = 0, all = 0;
  if (std::sscanf(line.c_str(), "progress %lf %lf", &done, &all) == 2) {
    const double now = all > 0 ? std::min(1.0, done / all) : 0;
    if (now < progress_) ++part_;
    progress_ = now;
  } else if (!line.empty())
    last_line_ = line;
}

void BackgroundFit::read_on() {
  constexpr std::size_t kLongest = 4096;
  std::array<char, 4096> bytes;
  ssize_t got;
  while ((got = ::read(fd_, bytes.data(), bytes.size())) > 0)
    for (const char c : std::string_view(bytes.data(), static_cast<std::size_t>(got)))
      if (c == '\n')
        take(std::exchange(line_, {}));
      else if (line_.size() < kLongest)
        line_ += c;
}

BackgroundFit::State BackgroundFit::poll() {
  if (state_ != State::running) return state_;
  int status = 0;
  const bool ended = ::waitpid(child_, &status, WNOHANG) == child_;
  read_on();
  if (!ended) return state_;
  const bool well = WIFEXITED(status) && WEXITSTATUS(status) == 0;
  state_ = well ? State::done : State::failed;
  if (well) progress_ = 1;
  if (!well && last_line_.empty()) last_line_ = "the fit ended without a word";
  return state_;
}

}  // namespace ferrule
