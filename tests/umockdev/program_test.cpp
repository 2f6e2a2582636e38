// Whole runs of the program with a device, until a button, a signal or the cable ends them.
#include <poll.h>
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <functional>

#include "haptic/hid/force_stick.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/umockdev/node.hpp"

namespace ferrule {
namespace {

using testing::Node;
using ProgramWithDevice = testing::Testbed;

const std::string kProgram = FERRULE_PROGRAM;

double seconds() {
  static const auto kBegin = std::chrono::steady_clock::now();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - kBegin).count();
}

// What became of a run of the program's record with a device.
struct Ran {
  int status;  // of wait
  std::string output;
  bool file;    // is the first episode there?
  double felt;  // the largest force along X
  double left;  // the largest that is there after the program's end and two lives of an effect
};

using Hand = std::function<void(FakeFirmware&, double)>;

// What `run` makes of it while the firmware's time passes with the clock's. `hand` acts on the
// firmware, given the time since the program enabled the motors; `act` once, 2.5 s after that.
Ran watched(Node& node, const Hand& hand, const std::function<void()>& act,
            const std::function<void(Ran&)>& run) {
  Ran ran{};
  node.with([](FakeFirmware& f) {  // just switched on, at rest
    f.write(std::vector<std::uint8_t>{0x1C, 0x08});
    f.deflect({});
    f.press(0);
    f.advance(seconds());
  });
  std::atomic<bool> over = false;
  std::thread clock([&] {
    double enabled = -1;
    bool acted = false;
    while (!over) {
      node.with([&](FakeFirmware& f) {
        const double now = seconds();
        if (enabled < 0 && f.actuators()) enabled = now;
        if (enabled >= 0) hand(f, now - enabled);
        f.advance(now);
        ran.felt = std::max(ran.felt, std::abs(f.force()[0]));
        if (!acted && enabled >= 0 && now - enabled > 2.5) {
          acted = true;
          act();
        }
      });
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  run(ran);
  std::this_thread::sleep_for(std::chrono::duration<double>(2 * ForceOutput::kDuration));
  over = true;
  clock.join();
  const auto left = node.with([](FakeFirmware& f) {
    f.advance(seconds());
    return f.force();
  });
  ran.left = std::max(std::abs(left[0]), std::abs(left[1]));
  return ran;
}

// `signal` is sent to the program 2.5 s after it enabled the motors. `errors`: where its stderr
// goes.
Ran record(Node& node, int signal, const Hand& hand, const std::string& more = "",
           const std::string& errors = "2>&1") {
  const testing::TemporaryFolder folder;
  std::atomic<pid_t> program = 0;
  const auto act = [&] {
    if (signal) ::kill(program, signal);
  };
  return watched(node, hand, act, [&](Ran& ran) {
    const std::string command =
        "echo $$; exec " + kProgram +
        " record --device auto --episodes 2 --set limits.force_uN=1000 --out " + (folder / "out") +
        more + " " + errors;
    FILE* const pipe = ::popen(command.c_str(), "r");
    for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) {
      ran.output += static_cast<char>(c);
      if (program == 0 && c == '\n') program = std::stoi(ran.output);
    }
    ran.status = ::pclose(pipe);
    ran.file = std::filesystem::exists(folder / "out/episode_0001.h5");
  });
}

// At a terminal that is closed while an episode runs.
Ran record_and_hang_up(Node& node, const Hand& hand) {
  const testing::TemporaryFolder folder;
  std::atomic<bool> hang_up = false;
  return watched(
      node, hand, [&] { hang_up = true; },
      [&](Ran& ran) {
        const std::string out = folder / "out";
        int terminal = -1;
        const pid_t program = ::forkpty(&terminal, nullptr, nullptr, nullptr);
        if (program == 0) {
          ::execl(kProgram.c_str(), "ferrule", "record", "--device", "auto", "--set",
                  "limits.force_uN=1000", "--out", out.c_str(), nullptr);
          ::_exit(1);
        }
        pollfd readable{terminal, POLLIN, 0};
        std::array<char, 256> part;
        bool started = false;
        while (!hang_up) {
          if (::poll(&readable, 1, 10) <= 0) continue;
          const ssize_t length = ::read(terminal, part.data(), part.size());
          if (length <= 0) break;  // it has ended
          ran.output.append(part.data(), static_cast<std::size_t>(length));
          if (!started && ran.output.find("space starts") != std::string::npos)
            started = ::write(terminal, " ", 1) == 1;
        }
        ::close(terminal);
        ::waitpid(program, &ran.status, 0);
        ran.file = std::filesystem::exists(out + "/episode_0001.h5");
      });
}

// Against the lead-in, and held there.
void hold(FakeFirmware& f, double t) {
  f.press(0);
  f.deflect({-static_cast<int>(24000 * std::min(1.0, t / 2)), 0, 0, 0, 0, 0});
}

// A button, Ctrl-C, a kill or the cable: there is no force after each of them.
TEST_F(ProgramWithDevice, TheProgramRecordsUntilItIsEndedAndLeavesNoForce) {
  Node node(testbed_, FakeModel::pid_22, 0);
  const auto stopped = [&] {
    return node.with([](FakeFirmware& f) { return !f.actuators() && f.effects() == 0; });
  };
  const Ran pressed =
      record(node, 0, [](FakeFirmware& f, double t) { f.press(std::fmod(t, 2.0) > 1.0 ? 1 : 0); });
  EXPECT_EQ(pressed.status, 0) << pressed.output;
  EXPECT_NE(pressed.output.find("stopped_short"), std::string::npos) << pressed.output;
  EXPECT_TRUE(pressed.file);
  EXPECT_TRUE(stopped());

  const Ran interrupted = record(node, SIGINT, hold);
  EXPECT_TRUE(WIFEXITED(interrupted.status) && WEXITSTATUS(interrupted.status) == 130);
  EXPECT_NE(interrupted.output.find("stopped by Ctrl-C"), std::string::npos) << interrupted.output;
  EXPECT_TRUE(interrupted.file) << interrupted.output;
  EXPECT_GT(interrupted.felt, 0.01);
  EXPECT_EQ(interrupted.left, 0);
  EXPECT_TRUE(stopped());

  const Ran killed = record(node, SIGKILL, hold);
  EXPECT_TRUE(WIFSIGNALED(killed.status));
  EXPECT_FALSE(killed.file) << killed.output;
  EXPECT_FALSE(stopped());  // nobody could say stop
  EXPECT_GT(killed.felt, 0.01);
  EXPECT_EQ(killed.left, 0);  // but the effects ended

  const Ran lost = record(node, 0, [](FakeFirmware& f, double t) {
    f.press(0);
    if (t > 1) f.unplug();
  });
  EXPECT_TRUE(WIFEXITED(lost.status) && WEXITSTATUS(lost.status) == 4) << lost.output;
  EXPECT_NE(lost.output.find("the device was lost"), std::string::npos) << lost.output;
  EXPECT_TRUE(lost.file);
}

// Nothing can be said any more: the force is taken away and the episode kept all the same.
TEST_F(ProgramWithDevice, WhereNobodyReadsItsWordsItLeavesNoForce) {
  Node node(testbed_, FakeModel::pid_22, 0);
  for (const char* errors : {"2>&-", "2>/dev/full"}) {
    const Ran silent = record(node, SIGINT, hold, "", errors);
    EXPECT_TRUE(WIFEXITED(silent.status) && WEXITSTATUS(silent.status) == 130) << silent.output;
    EXPECT_TRUE(silent.file) << errors << " status " << silent.status << " " << silent.output;
    EXPECT_GT(silent.felt, 0.01);
    EXPECT_EQ(silent.left, 0);
    EXPECT_TRUE(node.with([](FakeFirmware& f) { return !f.actuators() && f.effects() == 0; }));
  }
  const Ran left_alone = record_and_hang_up(node, hold);
  EXPECT_TRUE(WIFEXITED(left_alone.status) && WEXITSTATUS(left_alone.status) == 130)
      << left_alone.status << left_alone.output;
  EXPECT_TRUE(left_alone.file) << left_alone.output;
  EXPECT_GT(left_alone.felt, 0.01);
  EXPECT_EQ(left_alone.left, 0);
  EXPECT_TRUE(node.with([](FakeFirmware& f) { return !f.actuators() && f.effects() == 0; }));
}

// The first episode ends by a button, the motors are off: then the cable.
TEST_F(ProgramWithDevice, LostBetweenEpisodesTheEarlierOnesAreTold) {
  Node node(testbed_, FakeModel::pid_22, 0);
  const Ran lost = record(
      node, 0,
      [](FakeFirmware& f, double t) {
        f.press(t > 1 ? 1 : 0);
        if ((t > 1 && !f.actuators()) || t > 10) f.unplug();
      },
      " --json");
  EXPECT_TRUE(WIFEXITED(lost.status) && WEXITSTATUS(lost.status) == 4) << lost.output;
  EXPECT_NE(lost.output.find("the device was lost"), std::string::npos) << lost.output;
  EXPECT_NE(lost.output.find("episode_0001.h5"), std::string::npos) << lost.output;
  EXPECT_TRUE(lost.file);
}

TEST_F(ProgramWithDevice, LostBeforeTheKeyThatStartsAnEpisodeTheProgramEnds) {
  Node node(testbed_, FakeModel::pid_22, 0);
  const testing::TemporaryFolder folder;
  const std::string out = folder / "out";
  int terminal = -1;
  const pid_t program = ::forkpty(&terminal, nullptr, nullptr, nullptr);
  if (program == 0) {
    ::execl(kProgram.c_str(), "ferrule", "record", "--device", "auto", "--out", out.c_str(),
            nullptr);
    ::_exit(1);
  }
  ASSERT_GT(program, 0);
  std::string output;
  pollfd readable{terminal, POLLIN, 0};
  std::array<char, 256> part;
  while (::poll(&readable, 1, 60000) > 0) {
    const ssize_t length = ::read(terminal, part.data(), part.size());
    if (length <= 0) break;  // it has ended
    output.append(part.data(), static_cast<std::size_t>(length));
    if (output.find("space starts") != std::string::npos)
      node.with([](FakeFirmware& f) { f.unplug(); });
  }
  ::kill(program, SIGKILL);  // where it waits for ever
  int status = 0;
  ::waitpid(program, &status, 0);
  ::close(terminal);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 4) << output;
  EXPECT_NE(output.find("the device was lost"), std::string::npos) << output;
  EXPECT_TRUE(std::filesystem::is_empty(out));
}

}  // namespace
}  // namespace ferrule
