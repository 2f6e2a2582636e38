#include "controller/program_policy.hpp"

#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <limits>
#include <mutex>
#include <stdexcept>

#include "controller/policy_process.hpp"

namespace ferrule {
namespace {

constexpr std::size_t kShownAnswer = 80;     // bytes of an answer in a message
constexpr std::size_t kMostSaid = 64 << 10;  // bytes that are passed on
constexpr const char* kEndedBySystem = "the system ended the policy: ";
constexpr std::size_t kTries = 10;  // trials in which it may fail to begin with

// The processes that wait for a trial, and what is known of all.
class Processes {
 public:
  Processes(PolicyProcess::Work work, const ProgramSettings& settings)
      : settings_(settings), work_(std::move(work)) {}
  ~Processes() {
    for (const auto& process : free_) process->close();  // before one of them is waited for
  }
  Processes(const Processes&) = delete;
  Processes& operator=(const Processes&) = delete;

  const ProgramSettings& settings() const noexcept { return settings_; }

  // Throws std::runtime_error.
  std::unique_ptr<PolicyProcess> take() {
    const std::lock_guard lock(mutex_);
    if (!served_ && failed_ >= kTries)
      throw std::runtime_error("the policy failed in its first 10 trials and is asked no more: " +
                               last_failure_);
    if (free_.empty())
      return std::make_unique<PolicyProcess>(
          work_, [this](const std::string& text) { pass_on(text); }, settings_.stop);
    std::unique_ptr<PolicyProcess> process = std::move(free_.back());
    free_.pop_back();
    return process;
  }
  // After a trial without failure.
  void give_back(std::unique_ptr<PolicyProcess> process) {
    const std::lock_guard lock(mutex_);
    served_ = true;
    free_.push_back(std::move(process));
  }
  void failed(const std::string& why) {
    const std::lock_guard lock(mutex_);
    if (++failed_ <= kTries) last_failure_ = why;
  }

 private:
  void pass_on(const std::string& text) {
    const std::size_t before = said_.fetch_add(text.size());
    if (!settings_.said || before >= kMostSaid) return;
    settings_.said(text.substr(0, kMostSaid - before));
    if (before + text.size() >= kMostSaid)
      settings_.said("\n(what else the policy says on its standard error is left out)\n");
  }

  const ProgramSettings settings_;
  const PolicyProcess::Work work_;
  std::atomic<std::size_t> said_ = 0;
  std::mutex mutex_;
  bool served_ = false;  // a trial without failure
  std::size_t failed_ = 0;
  std::string last_failure_;
  std::vector<std::unique_ptr<PolicyProcess>> free_;
};

[[noreturn]] void answered_no(const char* what, const Json& answer) {
  throw std::runtime_error(std::string("the policy answered ") + what + ": " +
                           printable(answer.dump(-1, ' ', true), kShownAnswer));
}

std::vector<double> listed(const HandPose& five) {
  return {five.begin(), five.end()};
}

HandTwist velocity_of(const Json& answer) {
  const bool there = answer.is_object() && answer.contains("velocity");
  const Json velocity = there ? answer["velocity"] : Json();
  HandTwist v;
  bool numbers = velocity.is_array() && velocity.size() == 5;
  for (std::size_t i = 0; numbers && i < 5; ++i) {
    numbers = velocity[i].is_number();
    if (numbers) v[static_cast<Eigen::Index>(i)] = velocity[i];
  }
  if (!numbers) answered_no(R"(no {"velocity": [5 numbers]})", answer);
  return v;
}

bool says_done(const Json& answer) {
  const auto done = answer.find("done");
  if (done == answer.end()) return false;
  if (!done->is_boolean()) answered_no(R"("done" neither true nor false)", answer);
  return *done;
}

class ProgramPolicy : public Controller {
 public:
  ProgramPolicy(std::shared_ptr<Processes> processes, std::uint64_t trial)
      : processes_(std::move(processes)) {
    const ProgramSettings& s = processes_->settings();
    guarded([&] {
      process_ = processes_->take();
      const Json answer = process_->ask(
          {{"reset", {{"trial", trial}, {"seed", s.seed}, {"control_hz", s.control_hz}}}},
          s.start_timeout);
      if (!answer.is_object()) answered_no("a reset with no object", answer);
    });
  }
  ~ProgramPolicy() override {
    if (process_) processes_->give_back(std::move(process_));
  }

  HandTwist command(const Observation& o) noexcept override {
    HandTwist v = HandTwist::Constant(std::numeric_limits<double>::quiet_NaN());
    if (!process_) return v;
    guarded([&] {
      const Json question = {{"wrench", listed(o.wrench)},
                             {"depth", o.depth},
                             {"time", o.time},
                             {"displacement", listed(o.displacement)},
                             {"height", o.height},
                             {"force_limit", number_or_null(o.force_limit)}};
      const Json answer = process_->ask(question, processes_->settings().timeout);
      v = velocity_of(answer);
      done_ = says_done(answer);
    });
    return v;
  }
  bool done() const noexcept override { return done_; }
  std::string failure() const override { return failure_; }

 private:
  template <class Work>
  void guarded(const Work& work) noexcept {
    try {
      work();
    } catch (const PolicyKilled& error) {
      failure_ = std::string(kEndedBySystem) + error.what();
      process_.reset();
    } catch (const std::exception& error) {
      failure_ = error.what();
      process_.reset();
      processes_->failed(failure_);
    }
  }

  std::shared_ptr<Processes> processes_;
  std::unique_ptr<PolicyProcess> process_;  // null: it failed
  bool done_ = false;
  std::string failure_;
};

// In the fork: the answer to a question.
Json answer(const Json& question, const MakeController& make,
            std::unique_ptr<Controller>& controller) {
  try {
    if (question.contains("reset")) {
      controller.reset();
      controller = make(question["reset"]["trial"]);
      return Json::object();
    }
    Observation o{};
    for (Eigen::Index i = 0; i < o.wrench.size(); ++i) {
      o.wrench[i] = question["wrench"][static_cast<std::size_t>(i)];
      o.displacement[i] = question["displacement"][static_cast<std::size_t>(i)];
    }
    o.depth = question["depth"];
    o.time = question["time"];
    o.height = question["height"];
    if (question["force_limit"].is_number()) o.force_limit = question["force_limit"];
    const HandTwist v = controller->command(o);
    if (const std::string why = controller->failure(); !why.empty()) return {{"error", why}};
    return {{"velocity", std::vector<double>(v.begin(), v.end())}, {"done", controller->done()}};
  } catch (const std::bad_alloc&) {
    return {{"error", "it takes too much memory"}};
  } catch (const std::exception& error) {
    return {{"error", error.what()}};
  }
}

void serve(int socket, const MakeController& make) {
  std::unique_ptr<Controller> controller;
  std::string line;
  char bytes[4096];
  for (ssize_t n; (n = ::read(socket, bytes, sizeof bytes)) > 0;) {
    line.append(bytes, static_cast<std::size_t>(n));
    if (line.back() != '\n') continue;
    const std::string text = answer(Json::parse(line), make, controller)
                                 .dump(-1, ' ', false, Json::error_handler_t::replace) +
                             "\n";
    if (write_all(socket, text.data(), text.size()) != 0) return;
    line.clear();
  }
}

MakeController asking(PolicyProcess::Work work, const ProgramSettings& settings) {
  const auto processes = std::make_shared<Processes>(std::move(work), settings);
  return [processes](std::uint64_t trial) {
    return std::make_unique<ProgramPolicy>(processes, trial);
  };
}

}  // namespace

bool ended_by_system(const std::string& why) {
  return why.starts_with(kEndedBySystem);
}

MakeController program_policy(const std::string& command, const ProgramSettings& settings) {
  return asking(
      [command](int socket, int error) {
        execute({"sh", "-c", command}, socket, socket, error);
      },
      settings);
}

MakeController forked_policy(const MakeController& make, std::size_t memory,
                             const ProgramSettings& settings) {
  return asking(
      [make, memory](int socket, int) {
        be_quiet();
        only_read_files();
        limit_memory(memory);
        serve(socket, make);
      },
      settings);
}

}  // namespace ferrule
