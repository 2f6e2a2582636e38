#include "capture/recorder.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <cstring>
#include <fstream>

#include "capture/replay.hpp"
#include "sim/scene/draw.hpp"
#include "tests/compare.hpp"
#include "tests/episodes.hpp"
#include "tests/scenes.hpp"
#include "tests/temporary_folder.hpp"

namespace ferrule {
namespace {

namespace fs = std::filesystem;

TEST(Episode, IsReadBackBitForBit) {
  const testing::TemporaryFolder folder;
  const std::string file = testing::record(testing::quick(), folder.path(), 1);
  const Episode episode = read_episode(file);
  EXPECT_EQ(episode.info.outcome, Outcome::inserted);
  const std::string copy = folder / "copy.h5";
  write_episode(copy, episode);
  EXPECT_EQ(read_episode(copy).rows, episode.rows);
  EXPECT_FALSE(fs::exists(folder / "episode_0001.part"));
}

TEST(Replay, VerifiesARecordedEpisodeAndFindsAChangedBit) {
  const testing::TemporaryFolder folder;
  Episode episode = read_episode(testing::record(testing::quick(), folder.path(), 1));
  EXPECT_FALSE(verify(episode).has_value());
  for (const Block& b : kBlocks) {
    Episode changed = episode;
    double& x = changed.rows(300, b.begin);
    x = std::nextafter(x, 1e9);
    const auto d = verify(changed);
    ASSERT_TRUE(d.has_value()) << b.name;
    EXPECT_NEAR(static_cast<double>(d->row), 300, 1) << b.name;
  }
}

TEST(Replay, FindsAChangedOutcomeAndMissingRows) {
  const testing::TemporaryFolder folder;
  Episode episode = read_episode(testing::record(testing::quick(), folder.path(), 1));
  Episode other = episode;
  other.info.outcome = Outcome::jam;
  ASSERT_TRUE(verify(other).has_value());
  EXPECT_EQ(verify(other)->column, "outcome");
  other = episode;
  other.rows = Rows(episode.rows.topRows(episode.rows.rows() / 2));
  ASSERT_TRUE(verify(other).has_value());
  EXPECT_EQ(verify(other)->column, "outcome");
}

TEST(Recorder, AKilledProcessLosesAtMostATenthOfASecond) {
  const testing::TemporaryFolder folder;
  const Scene scene = testing::quick();
  for (const std::size_t killed_at : {150u, 777u, 1500u}) {
    const pid_t child = ::fork();
    if (child == 0) {
      const State start = draw_start(scene, 1, 1);
      auto device = simulated_operator(testing::setup(scene, 1), 0.8);
      Recorder recorder(folder.path(), 1, testing::info_of(scene, 1, 1));
      std::size_t n = 0;
      run_insertion(testing::setup(scene, start), *device, testing::recording_settings(),
                    [&](const Tick& tick) {
                      recorder.add(make_row(tick));
                      if (++n == killed_at) ::kill(::getpid(), SIGKILL);
                      return true;
                    });
      ::_exit(0);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status));
    EXPECT_TRUE(episode_files(folder.path()).empty());
    const auto recovered = recover(folder.path());
    ASSERT_EQ(recovered.size(), 1u);
    EXPECT_EQ(recovered[0].rows, killed_at - killed_at % 100);
    const Episode episode = read_episode(recovered[0].file);
    EXPECT_EQ(episode.info.outcome, Outcome::interrupted);
    EXPECT_FALSE(verify(episode).has_value());
    fs::remove(recovered[0].file);
  }
}

// Killed after the goal, while the hand went on or the file was written.
TEST(Recover, KnowsFromTheRowsHowAnInsertionEnded) {
  const testing::TemporaryFolder folder;
  const Scene scene = testing::quick();
  const Episode whole = read_episode(testing::record(scene, folder.path(), 1));
  ASSERT_EQ(whole.info.outcome, Outcome::inserted);
  for (const auto& [rows, outcome] : {std::pair{whole.rows.rows(), Outcome::inserted},
                                      {Eigen::Index{200}, Outcome::interrupted}}) {
    {
      Recorder recorder(folder.path(), 2, whole.info);
      for (Eigen::Index n = 0; n < rows; ++n) recorder.add(whole.rows.row(n));
      recorder.flush();
    }  // left without finish
    const auto recovered = recover(folder.path());
    ASSERT_EQ(recovered.size(), 1u);
    EXPECT_EQ(recovered[0].outcome, outcome);
    const Episode episode = read_episode(recovered[0].file);
    EXPECT_EQ(episode.info.outcome, outcome);
    EXPECT_FALSE(verify(episode).has_value());
    fs::remove(recovered[0].file);
  }
}

TEST(Recover, TakesWhatIsWholeOfATornJournal) {
  const testing::TemporaryFolder folder;
  const Scene scene = testing::quick();
  {
    const State start = draw_start(scene, 1, 1);
    auto device = simulated_operator(testing::setup(scene, 1), 0.8);
    Recorder recorder(folder.path(), 1, testing::info_of(scene, 1, 1));
    std::size_t n = 0;
    run_insertion(testing::setup(scene, start), *device, testing::recording_settings(),
                  [&](const Tick& tick) {
                    recorder.add(make_row(tick));
                    return ++n != 500;
                  });
  }  // left without finish
  const std::string journal = folder / "episode_0001.part";
  fs::resize_file(journal, fs::file_size(journal) - sizeof(RowVector) * 5 / 4);
  const auto recovered = recover(folder.path());
  ASSERT_EQ(recovered.size(), 1u);
  EXPECT_EQ(recovered[0].rows, 498u);
  EXPECT_FALSE(fs::exists(journal));
}

TEST(Recover, LeavesAJournalThatHasNoRowsYet) {
  const testing::TemporaryFolder folder;
  std::string header;
  {
    Recorder recorder(folder.path(), 1, testing::info_of(testing::quick(), 1, 1));
    std::ifstream file(folder / "episode_0001.part");
    std::getline(file, header);
  }
  std::ofstream(folder / "episode_0001.part") << header << '\n';  // as a killed process leaves it
  const auto recovered = recover(folder.path());
  ASSERT_EQ(recovered.size(), 1u);
  EXPECT_EQ(recovered[0].rows, 0u);
  EXPECT_TRUE(recovered[0].file.empty());
}

TEST(Recover, LeavesAJournalAloneThatIsBeingWritten) {
  const testing::TemporaryFolder folder;
  const Scene scene = testing::quick();
  Recorder recorder(folder.path(), 1, testing::info_of(scene, 1, 1));
  const pid_t child = ::fork();  // locks belong to processes
  if (child == 0) {
    const auto recovered = recover(folder.path());
    ::_exit(recovered.size() == 1 && recovered[0].file.empty() ? 0 : 1);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
  EXPECT_TRUE(fs::exists(folder / "episode_0001.part"));
}

// Rows of a short insertion in a journal that is left without an end.
void leave_a_journal(const std::string& folder, std::size_t rows) {
  const Scene scene = testing::quick();
  const State start = draw_start(scene, 1, 1);
  auto device = simulated_operator(testing::setup(scene, 1), 0.8);
  Recorder recorder(folder, 1, testing::info_of(scene, 1, 1));
  std::size_t n = 0;
  run_insertion(testing::setup(scene, start), *device, testing::recording_settings(),
                [&](const Tick& tick) {
                  recorder.add(make_row(tick));
                  return ++n != rows;
                });
}

TEST(EpisodeClaim, ThatWaitsForItsStartIsLeftAloneAndKeepsItsNumber) {
  const testing::TemporaryFolder folder;
  EpisodeClaim claim(folder.path(), 1);
  const auto recovered = recover(folder.path());
  ASSERT_EQ(recovered.size(), 1u);
  EXPECT_NE(recovered[0].remark.find("still being recorded"), std::string::npos);
  EXPECT_TRUE(fs::exists(claim.journal()));
  EXPECT_EQ(EpisodeClaim(folder.path(), 1).number(), 2);
  Recorder recorder(std::move(claim), testing::info_of(testing::quick(), 1, 1));
  RowVector row = RowVector::Zero();
  recorder.add(row);
  EXPECT_EQ(recorder.finish(Outcome::interrupted), folder / "episode_0001.h5");
}

TEST(EpisodeClaim, ThatNeverBeganLeavesNothing) {
  const testing::TemporaryFolder folder;
  { const EpisodeClaim claim(folder.path(), 7); }
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(Recorder, ANameThatWasTakenMeanwhileMeansTheNextNumber) {
  const testing::TemporaryFolder folder;
  Recorder recorder(folder.path(), 1, testing::info_of(testing::quick(), 1, 1));
  RowVector row = RowVector::Zero();
  recorder.add(row);
  std::ofstream(folder / "episode_0001.h5") << "of somebody else";
  EXPECT_EQ(recorder.finish(Outcome::interrupted), folder / "episode_0002.h5");
  EXPECT_EQ(read_text(folder / "episode_0001.h5"), "of somebody else");
  EXPECT_TRUE(recover(folder.path()).empty());
}

TEST(Recover, OfAJournalBesideAnotherEpisodeOfItsNameTakesTheNextNumber) {
  const testing::TemporaryFolder folder, elsewhere;
  leave_a_journal(folder.path(), 500);
  fs::copy_file(testing::record(testing::quick(), elsewhere.path(), 2), folder / "episode_0001.h5");
  const auto recovered = recover(folder.path());
  ASSERT_EQ(recovered.size(), 1u);
  EXPECT_EQ(recovered[0].file, folder / "episode_0002.h5");
  EXPECT_EQ(read_episode(recovered[0].file).rows.rows(), 500);
  EXPECT_FALSE(fs::exists(folder / "episode_0001.part"));
}

TEST(Recover, RemovesTheJournalOfAnEpisodeThatHasAllOfIt) {
  const testing::TemporaryFolder folder;
  leave_a_journal(folder.path(), 500);
  fs::copy_file(folder / "episode_0001.part", folder / "kept");
  ASSERT_EQ(recover(folder.path()).size(), 1u);
  fs::copy_file(folder / "kept", folder / "episode_0001.part");
  const auto recovered = recover(folder.path());
  ASSERT_EQ(recovered.size(), 1u);
  EXPECT_TRUE(recovered[0].file.empty());
  EXPECT_FALSE(recovered[0].damaged);
  EXPECT_FALSE(fs::exists(folder / "episode_0001.part"));
}

TEST(Recover, TakesTheRowsBeforeADamagedOneAndKeepsTheJournal) {
  const testing::TemporaryFolder folder;
  leave_a_journal(folder.path(), 500);
  const std::string journal = folder / "episode_0001.part";
  std::string bytes = read_text(journal);
  const std::size_t row = kRowSize * sizeof(double);
  const double not_a_number = NAN;
  std::memcpy(&bytes[bytes.find('\n') + 1 + 317 * row + 5 * sizeof(double)], &not_a_number,
              sizeof(double));
  std::ofstream(journal, std::ios::binary) << bytes;
  const auto recovered = recover(folder.path());
  ASSERT_EQ(recovered.size(), 1u);
  EXPECT_TRUE(recovered[0].damaged);
  EXPECT_EQ(recovered[0].rows, 317u);
  EXPECT_EQ(read_episode(recovered[0].file).rows.rows(), 317);
  EXPECT_EQ(read_text(journal + ".damaged"), bytes);
  EXPECT_FALSE(fs::exists(journal));
}

TEST(Recover, RemovesNothingThatItCannotBringBack) {
  const testing::TemporaryFolder folder;
  leave_a_journal(folder.path(), 500);
  const std::string journal = folder / "episode_0001.part", whole = read_text(journal);
  const std::size_t header = whole.find('\n') + 1;
  for (const std::size_t size : {std::size_t{1}, header - 1, header + 1, header + 100}) {
    fs::resize_file(journal, 0);
    std::ofstream(journal, std::ios::binary) << whole.substr(0, size);
    const auto recovered = recover(folder.path());
    ASSERT_EQ(recovered.size(), 1u);
    EXPECT_TRUE(recovered[0].damaged) << size;
    EXPECT_EQ(read_text(journal), whole.substr(0, size));
  }
  for (const std::size_t size : {std::size_t{0}, header}) {
    std::ofstream(journal, std::ios::binary) << whole.substr(0, size);
    const auto recovered = recover(folder.path());
    ASSERT_EQ(recovered.size(), 1u);
    EXPECT_FALSE(recovered[0].damaged) << size;
    EXPECT_NE(recovered[0].remark.find("removed"), std::string::npos);
    EXPECT_FALSE(fs::exists(journal));
  }
}

TEST(NextEpisodeNumber, DoesNotOverflow) {
  const testing::TemporaryFolder folder;
  std::ofstream(folder / "episode_0041.h5") << "";
  std::ofstream(folder / "episode_x.h5") << "";
  EXPECT_EQ(next_episode_number(folder.path()), 42);
  std::ofstream(folder / "episode_99999999999.h5") << "";
  EXPECT_THROW(next_episode_number(folder.path()), BadInput);
}

TEST(Recover, SaysWhatIsWrongWithGarbage) {
  const testing::TemporaryFolder folder;
  std::ofstream(folder / "episode_0001.part") << "garbage\nmore";
  std::ofstream(folder / "episode_0002.part") << "{\"format\":\"ferrule journal\"}\n";
  std::ofstream(folder / "episode_0003.part") << "";
  for (const auto& r : recover(folder.path())) {
    EXPECT_TRUE(r.file.empty());
    EXPECT_FALSE(r.remark.empty());
  }
  EXPECT_TRUE(episode_files(folder.path()).empty());
}

TEST(Episode, DamagedFilesAreRefusedNotRead) {
  const testing::TemporaryFolder folder;
  const std::string file = testing::record(testing::quick(), folder.path(), 1);
  const auto size = fs::file_size(file);
  for (const auto part : {0.0, 0.1, 0.5, 0.9}) {
    const std::string torn = folder / "torn.h5";
    fs::copy_file(file, torn, fs::copy_options::overwrite_existing);
    fs::resize_file(torn, static_cast<std::uintmax_t>(part * static_cast<double>(size)));
    EXPECT_THROW(read_episode(torn), FileTrouble) << part;
  }
  std::ofstream(folder / "text.h5") << "hello";
  EXPECT_THROW(read_episode(folder / "text.h5"), FileTrouble);
  EXPECT_THROW(read_episode(folder / "none.h5"), FileTrouble);
}

}  // namespace
}  // namespace ferrule
