#include "sim/base/child_process.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <memory>
#include <thread>

#include "sim/base/json_fields.hpp"
#include "tests/processes.hpp"
#include "tests/temporary_folder.hpp"

namespace ferrule {
namespace {

using testing::comes, testing::runs;

int exit_code_of(const std::function<void()>& work, std::vector<int> keep = {}) {
  ChildProcess child(std::move(keep), work);
  const int status = child.wait();
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

TEST(ChildProcess, EndsAsItsWorkDoes) {
  EXPECT_EQ(exit_code_of([] {}), 0);
  EXPECT_EQ(exit_code_of([] { throw 1; }), 1);
  EXPECT_EQ(exit_code_of([] { ::_exit(7); }), 7);
  EXPECT_EQ(exit_code_of([] { ::raise(SIGTERM); }), -SIGTERM);
  EXPECT_EQ(exit_code_of([] { execute({"sh", "-c", "exit 9"}, -1, -1, -1); }), 9);
  EXPECT_EQ(exit_code_of([] { execute({"no such program"}, -1, -1, -1); }), 127);
}

TEST(ChildProcess, HasOnlyTheFilesThatItKeeps) {
  const int kept = ::open("/dev/null", O_RDONLY), other = ::open("/dev/null", O_RDONLY);
  EXPECT_EQ(exit_code_of(
                [&] {
                  const bool has_kept = ::fcntl(kept, F_GETFD) >= 0;
                  ::_exit(has_kept && ::fcntl(other, F_GETFD) < 0 ? 0 : 1);
                },
                {kept}),
            0);
  ::close(kept);
  ::close(other);
}

TEST(ChildProcess, HandlesAndBlocksNoSignal) {
  const auto before = ::signal(SIGTERM, SIG_IGN);
  sigset_t all, was;
  sigfillset(&all);
  ::pthread_sigmask(SIG_SETMASK, &all, &was);
  EXPECT_EQ(exit_code_of([] { ::raise(SIGTERM); }), -SIGTERM);
  ::pthread_sigmask(SIG_SETMASK, &was, nullptr);
  ::signal(SIGTERM, before);
}

TEST(ChildProcess, IsKilledWithAllThatItStarted) {
  const testing::TemporaryFolder folder;
  auto child = std::make_unique<ChildProcess>(std::vector<int>(), [&] {
    execute({"sh", "-c", "sleep 600 & echo $! > " + (folder / "sleeper") + "; wait"}, -1, -1, -1);
  });
  const auto sleeper = [&] { return testing::told_in(folder / "sleeper"); };
  ASSERT_TRUE(comes([&] { return runs(sleeper()); }));
  EXPECT_FALSE(child->ended());
  child.reset();
  EXPECT_TRUE(comes([&] { return !runs(sleeper()); }));
}

TEST(ChildProcess, DoesNotOutliveAProgramThatIsKilled) {
  const testing::TemporaryFolder folder;
  const pid_t program = ::fork();
  if (program == 0) {
    // Made by a thread that ends long before the program does.
    std::unique_ptr<ChildProcess> child;
    std::thread([&] {
      child = std::make_unique<ChildProcess>(std::vector<int>(), [&] {
        ::signal(SIGTERM, SIG_IGN);
        write_text(folder / std::to_string(::getpid()), "");
        execute({"sh", "-c", "sleep 600 & touch " + folder.path() + "/$!; sleep 600"}, -1, -1, -1);
      });
    }).join();
    ::pause();
    ::_exit(0);
  }
  const auto started = [&] {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
      if (const std::string name = entry.path().filename(); name.find('.') == name.npos)
        names.push_back(name);
    return names;
  };
  ASSERT_TRUE(comes([&] { return started().size() == 2; }));
  for (const std::string& process : started()) EXPECT_TRUE(runs(process));
  ::kill(program, SIGKILL);
  ::waitpid(program, nullptr, 0);
  for (const std::string& process : started())
    EXPECT_TRUE(comes([&] { return !runs(process); })) << process;
}

TEST(ChildProcess, TakesNoMoreMemoryAndTimeThanItMay) {
  const auto takes = [](std::size_t bytes) {
    be_quiet();
    limit_memory(64 << 20);
    const std::string text(bytes, 'x');
    ::_exit(::write(STDERR_FILENO, text.data(), bytes) < 0 ? 2
                                                           : 0);  // /dev/null; or it is not made
  };
  EXPECT_EQ(exit_code_of([&] { takes(16 << 20); }), 0);
  EXPECT_EQ(exit_code_of([&] { takes(256 << 20); }), 1);
  EXPECT_EQ(exit_code_of([] {
              be_quiet();
              limit_time(1);
              const volatile bool forever = true;  // a loop that does nothing is undefined
              while (forever) {
              }
            }),
            -SIGXCPU);
}

TEST(ChildProcess, OnlyReadsFiles) {
  if (::syscall(SYS_landlock_create_ruleset, nullptr, 0, 1) < 1) GTEST_SKIP() << "no Landlock";
  const testing::TemporaryFolder folder;
  write_text(folder / "there", "text");
  const auto opens = [&](const std::string& name, int how) {
    return exit_code_of([&] {
      only_read_files();
      ::_exit(::open((folder / name).c_str(), how, 0600) >= 0);
    });
  };
  EXPECT_TRUE(opens("there", O_RDONLY));
  EXPECT_FALSE(opens("there", O_RDWR));
  EXPECT_FALSE(opens("there", O_WRONLY | O_TRUNC));
  EXPECT_FALSE(opens("new", O_WRONLY | O_CREAT));
  EXPECT_EQ(read_text(folder / "there"), "text");
  EXPECT_EQ(exit_code_of([] {
              only_read_files();
              execute({"true"}, -1, -1, -1);
            }),
            127);
}

}  // namespace
}  // namespace ferrule
