#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "capture/child.hpp"
#include "capture/episode.hpp"
#include "sim/base/content_hash.hpp"
#include "sim/base/random.hpp"
#include "tests/episodes.hpp"
#include "tests/scenes.hpp"
#include "tests/temporary_folder.hpp"

namespace ferrule {
namespace {

constexpr Eigen::Index kLong = 10 * EpisodeRows::kBlock + 100;

// Its rows are numbered; most of what is in them is 0.
Episode numbered(Eigen::Index rows) {
  Episode episode;
  episode.info = testing::info_of(load_scene("demo"), 1, 1);
  episode.rows.setZero(rows, kRowSize);
  for (Eigen::Index n = 0; n < rows; ++n) {
    episode.rows(n, kTime.begin) = static_cast<double>(n) * episode.info.period;
    episode.rows(n, kCommand.begin + 1) = std::sqrt(static_cast<double>(n));
  }
  return episode;
}

TEST(EpisodeRows, OfAFileAreThoseThatWereWrittenWhereverOneLooks) {
  const testing::TemporaryFolder folder;
  const Episode episode = numbered(kLong);
  write_episode(folder / "long.h5", episode);
  const EpisodeRows stored = open_episode(folder / "long.h5");
  ASSERT_EQ(stored.count(), kLong);
  RandomStream random(1, 1, "rows");
  for (int look = 0; look < 30; ++look) {
    const auto n = static_cast<Eigen::Index>(random.uniform() * static_cast<double>(kLong));
    EXPECT_EQ(stored.row(n), episode.rows.row(n)) << n;
  }
  EXPECT_EQ(read_episode(folder / "long.h5").rows, episode.rows);
  EXPECT_FALSE(file_difference(folder / "long.h5").has_value());
}

TEST(EpisodeRows, KeepTheFirstBlocksAndReadTheOthersAgain) {
  const Episode episode = numbered(kLong);
  const EpisodeRows memory = episode;
  std::vector<Eigen::Index> read;
  const EpisodeRows rows(episode.info, kLong, [&](Eigen::Index first, Eigen::Index) {
    read.push_back(first / EpisodeRows::kBlock);
    return memory.part_of(first);
  });
  for (int pass = 0; pass < 2; ++pass)
    for (Eigen::Index n = 0; n < kLong; n += 100) ASSERT_EQ(rows.row(n), episode.rows.row(n));
  EXPECT_EQ(read, (std::vector<Eigen::Index>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 7, 8, 9, 10}));
}

// What is before the damage was read by then.
TEST(EpisodeRows, SayWhereAFileIsDamaged) {
  const testing::TemporaryFolder folder;
  Episode episode = numbered(2 * EpisodeRows::kBlock);
  episode.rows(EpisodeRows::kBlock + 5, kHolder.begin) = NAN;
  write_episode(folder / "damaged.h5", episode);
  const EpisodeRows stored = open_episode(folder / "damaged.h5");
  EXPECT_EQ(stored.row(5), episode.rows.row(5));
  try {
    stored.row(EpisodeRows::kBlock);
    ADD_FAILURE() << "it was read";
  } catch (const FileTrouble& error) {
    EXPECT_NE(std::string(error.what()).find("holder_wrench at row 8197"), std::string::npos)
        << error.what();
  }
}

TEST(EpisodeRows, AreThoseOfTheHashWhateverTheFileBecomes) {
  const testing::TemporaryFolder folder;
  const std::string file = folder / "replaced.h5";
  const Episode episode = numbered(kLong);
  write_episode(file, episode);
  const std::string written = sha1_of_file(file);
  std::string hash;
  const EpisodeRows stored = open_episode(file, &hash);
  EXPECT_EQ(hash, written);
  std::filesystem::remove(file);
  for (const bool replaced : {false, true}) {
    if (replaced) write_episode(file, numbered(10));
    for (const Eigen::Index n :
         {kLong - 1, kLong - EpisodeRows::kBlock, Eigen::Index{0}, kLong - 1})
      EXPECT_EQ(stored.row(n), episode.rows.row(n)) << n;
  }
}

TEST(EpisodeRows, OfAFileThatIsCutMeanwhileAreATrouble) {
  const testing::TemporaryFolder folder;
  const std::string file = folder / "cut.h5";
  const Episode episode = numbered(kLong);
  write_episode(file, episode);
  const EpisodeRows stored = open_episode(file);
  EXPECT_EQ(stored.row(5), episode.rows.row(5));
  std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
  EXPECT_THROW(stored.row(kLong - 1), FileTrouble);
}

TEST(EpisodeRows, AreRatedWithoutChangingAnyOfThem) {
  const testing::TemporaryFolder folder;
  const std::string file = testing::record(testing::quick(), folder.path(), 1);
  const Episode before = read_episode(file);
  rate_episode(file, 4);
  const Episode after = read_episode(file);
  EXPECT_EQ(after.rows, before.rows);
  EXPECT_EQ(after.info.rating, 4);
  EXPECT_FALSE(file_difference(file).has_value());
}

TEST(Child, SaysWhatStoppedItAfterWhatItSent) {
  const testing::TemporaryFolder folder;
  Child child(folder / "file", Child::Work::reads, [](Child::Parent& parent) {
    const int number = 7;
    parent.send(&number, sizeof number);
    throw FileTrouble("half way");
  });
  int number = 0;
  child.receive(&number, sizeof number);
  EXPECT_EQ(number, 7);
  try {
    child.receive(&number, sizeof number);
    ADD_FAILURE() << "it went on";
  } catch (const FileTrouble& error) {
    EXPECT_STREQ(error.what(), "half way");
  }
}

TEST(Child, ThatEndsWithoutAWordIsATrouble) {
  const testing::TemporaryFolder folder;
  for (const auto kind : {Child::Work::reads, Child::Work::writes}) {
    Child child(folder / "file", kind, [](Child::Parent&) { std::abort(); });
    char byte = 0;
    EXPECT_THROW(child.receive(&byte, 1), FileTrouble);
  }
}

}  // namespace
}  // namespace ferrule
