#include "sim/base/child_process.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <sys/xattr.h>
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

// By setsid, and with parents that are gone.
TEST(ChildProcess, WhatLeftItsGroupAndSessionIsKilledToo) {
  for (const std::string end : {"exit 3", "sleep 600", "kill -9 $$"}) {
    const testing::TemporaryFolder folder;
    const std::string command =
        "cd " + folder.path() +
        "; setsid sh -c 'echo $$ > a; sleep 600' &\n"
        "(setsid sh -c 'sleep 600 & echo $! > b; (sleep 600 & echo $! > c)' &)\n"
        "while ! [ -s a -a -s b -a -s c ]; do sleep 0.01; done; touch all; " +
        end;
    auto child = std::make_unique<ChildProcess>(std::vector<int>(), [&] {
      execute({"sh", "-c", command}, -1, -1, -1);
    });
    ASSERT_TRUE(comes([&] { return std::filesystem::exists(folder / "all"); }));
    if (end == "exit 3") {
      EXPECT_EQ(WEXITSTATUS(child->wait()), 3);
    }
    if (end == "kill -9 $$") {
      EXPECT_EQ(WTERMSIG(child->wait()), SIGKILL);
    }
    child.reset();
    for (const char* name : {"a", "b", "c"})
      EXPECT_FALSE(runs(testing::told_in(folder / name))) << end << " " << name;
  }
}

// The child itself may call setsid.
TEST(ChildProcess, CallsSetsidAndIsKilled) {
  const testing::TemporaryFolder folder;
  auto child = std::make_unique<ChildProcess>(std::vector<int>(), [&] {
    if (::setsid() < 0) ::_exit(9);
    execute({"sh", "-c", "echo $$ > " + (folder / "own") + "; sleep 600"}, -1, -1, -1);
  });
  const auto own = [&] { return testing::told_in(folder / "own"); };
  ASSERT_TRUE(comes([&] { return runs(own()); }));
  child.reset();
  EXPECT_FALSE(runs(own()));
}

TEST(ChildProcess, WhatLeftTheSessionDoesNotOutliveAProgramThatIsKilled) {
  const testing::TemporaryFolder folder;
  const pid_t program = ::fork();
  if (program == 0) {
    const ChildProcess child({}, [&] {
      execute({"sh", "-c",
               "(setsid sh -c 'echo $$ > " + (folder / "left") +
                   "; sleep 600' &)"
                   "; sleep 600"},
              -1, -1, -1);
    });
    ::pause();
    ::_exit(0);
  }
  const auto left = [&] { return testing::told_in(folder / "left"); };
  ASSERT_TRUE(comes([&] { return runs(left()); }));
  ::kill(program, SIGKILL);
  ::waitpid(program, nullptr, 0);
  EXPECT_TRUE(comes([&] { return !runs(left()); }));
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
  EXPECT_FALSE(opens("there", O_RDONLY | O_TRUNC));
  EXPECT_EQ(read_text(folder / "there"), "text");
  EXPECT_EQ(exit_code_of([] {
              only_read_files();
              execute({"true"}, -1, -1, -1);
            }),
            127);
}

TEST(ChildProcess, ChangesNoFile) {
  if (::syscall(SYS_landlock_create_ruleset, nullptr, 0, 1) < 1) GTEST_SKIP() << "no Landlock";
  const testing::TemporaryFolder folder;
  const std::string file = folder / "there", other = folder / "other";
  write_text(file, "text");
  const auto fails = [](const auto& change) {
    return exit_code_of([&] {
             only_read_files();
             ::_exit(change() < 0 ? 0 : 1);
           }) == 0;
  };
  struct stat before {
  }, after{};
  ::stat(file.c_str(), &before);
  EXPECT_TRUE(fails([&] { return ::truncate(file.c_str(), 0); }));
  EXPECT_TRUE(fails([&] { return ::chmod(file.c_str(), 0777); }));
  EXPECT_TRUE(fails([&] { return ::fchmodat(AT_FDCWD, file.c_str(), 0777, 0); }));
  EXPECT_TRUE(fails([&] { return ::syscall(452, AT_FDCWD, file.c_str(), 0777, 0); }));
  EXPECT_TRUE(fails([&] { return ::fchmod(::open(file.c_str(), O_RDONLY), 0777); }));
  EXPECT_TRUE(fails([&] { return ::chown(file.c_str(), ::getuid(), ::getgid()); }));
  EXPECT_TRUE(fails([&] { return ::utimensat(AT_FDCWD, file.c_str(), nullptr, 0); }));
  EXPECT_TRUE(fails([&] { return ::setxattr(file.c_str(), "user.x", "y", 1, 0); }));
  EXPECT_TRUE(fails([&] { return ::rename(file.c_str(), other.c_str()); }));
  EXPECT_TRUE(fails([&] { return ::link(file.c_str(), other.c_str()); }));
  EXPECT_TRUE(fails([&] { return ::symlink(file.c_str(), other.c_str()); }));
  EXPECT_TRUE(fails([&] { return ::unlink(file.c_str()); }));
  ::stat(file.c_str(), &after);
  EXPECT_EQ(read_text(file), "text");
  EXPECT_EQ(after.st_mode, before.st_mode);
  EXPECT_EQ(after.st_ctim.tv_nsec, before.st_ctim.tv_nsec);
  EXPECT_FALSE(std::filesystem::exists(other));
  EXPECT_TRUE(std::filesystem::exists(file));
}

}  // namespace
}  // namespace ferrule
