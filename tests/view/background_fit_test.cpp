#include "view/background_fit.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>

#include "sim/base/json_fields.hpp"
#include "tests/processes.hpp"
#include "tests/temporary_folder.hpp"

namespace ferrule {
namespace {

using testing::comes;

// A program in the place of ferrule.
std::string program(const testing::TemporaryFolder& folder, const std::string& script) {
  const std::string file = folder / "program";
  write_text(file, "#!/bin/sh\n" + script + "\n");
  std::filesystem::permissions(file, std::filesystem::perms::owner_all);
  return file;
}

TEST(BackgroundFit, TellsItsProgressAndHowItEnded) {
  const testing::TemporaryFolder folder;
  BackgroundFit done(program(folder,
                             "echo progress 3 4 >&2; test \"$FERRULE_PROGRESS\" = lines &&"
                             " test \"$*\" = 'fit a.h5 --out c.json'"),
                     {"a.h5"}, "c.json");
  EXPECT_TRUE(comes([&] { return done.poll() == BackgroundFit::State::done; }));
  BackgroundFit failed(program(folder, "echo progress 1 4 >&2; echo why >&2; exit 2"), {},
                       "c.json");
  EXPECT_TRUE(comes([&] { return failed.poll() == BackgroundFit::State::failed; }));
  EXPECT_EQ(failed.progress(), 0.25);
  EXPECT_EQ(failed.text(), "why");
}

TEST(BackgroundFit, DoesNotOutliveAWindowThatIsKilled) {
  const testing::TemporaryFolder folder;
  const std::string script =
      program(folder, "echo $$ > '" + (folder / "pid") + "'; exec sleep 600");
  const pid_t window = ::fork();
  if (window == 0) {
    const BackgroundFit fit(script, {}, "c.json");
    ::pause();
    ::_exit(0);
  }
  const auto pid = [&] { return testing::told_in(folder / "pid"); };
  ASSERT_TRUE(comes([&] { return testing::runs(pid()); }));
  ::kill(window, SIGKILL);
  ::waitpid(window, nullptr, 0);
  EXPECT_TRUE(comes([&] { return !testing::runs(pid()); }));
}

}  // namespace
}  // namespace ferrule
