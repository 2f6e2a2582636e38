#include "capture/episode_copies.hpp"

#include <gtest/gtest.h>

#include "tests/episodes.hpp"
#include "tests/scenes.hpp"
#include "tests/temporary_folder.hpp"

namespace ferrule {
namespace {

// Whatever a file says of itself: a copy is told by its rows.
TEST(EpisodeCopies, AreThoseWithTheSameRows) {
  const testing::TemporaryFolder folder;
  const Episode one = read_episode(testing::record(testing::quick(), folder.path(), 1)),
                other = read_episode(testing::record(testing::quick(), folder.path(), 2));
  EpisodeCopies copies;
  EXPECT_FALSE(copies.seen(one, "one.h5"));
  EXPECT_FALSE(copies.seen(other, "other.h5"));
  Episode again = one;
  again.info.operator_ = "somebody else";
  again.info.seed = again.info.trial = 99;
  const auto copy = copies.seen(again, "again.h5");
  ASSERT_TRUE(copy);
  EXPECT_EQ(copy->original, "one.h5");
  EXPECT_EQ(copy->text(), "again.h5 is left out: it has the rows of one.h5, a copy");
  again.rows(100, kHolder.begin) = std::nextafter(again.rows(100, kHolder.begin), 1e9);
  EXPECT_FALSE(copies.seen(again, "changed.h5"));
  again = one;
  again.rows = Rows(one.rows.topRows(one.rows.rows() - 1));
  EXPECT_FALSE(copies.seen(again, "shorter.h5"));
}

// As it would be in a file that somebody has changed.
void expect_refused(const Episode& episode, const std::string& file, const std::string& says) {
  write_episode(file, episode);
  try {
    read_episode(file);
    ADD_FAILURE() << "it was read";
  } catch (const FileTrouble& error) {
    EXPECT_NE(std::string(error.what()).find(says), std::string::npos) << error.what();
  }
}

TEST(Episode, IsNotInsertedUnlessItsRowsShowIt) {
  const testing::TemporaryFolder folder;
  const Episode whole = read_episode(testing::record(testing::quick(), folder.path(), 1));
  ASSERT_EQ(whole.info.outcome, Outcome::inserted);
  Episode cut = whole;
  cut.rows = Rows(whole.rows.topRows(whole.rows.rows() / 2));
  for (const std::uint64_t format : {kEpisodeFormat, kEpisodeFormat - 1}) {
    cut.info.format = format;
    expect_refused(cut, folder / ("cut" + std::to_string(format) + ".h5"), "not 8 um");
  }
  // Rows that reach the depth, and were failures before by the scene's limits.
  Json scene = parse_json(whole.info.scene, "scene");
  scene["limits"]["force_uN"] = 1e-3;
  Episode pushed = whole;
  pushed.info.scene = scene.dump();
  expect_refused(pushed, folder / "pushed.h5", "the rows end as ");
  scene = parse_json(whole.info.scene, "scene");
  scene["limits"]["time_s"] = 0.5;
  pushed.info.scene = scene.dump();
  expect_refused(pushed, folder / "late.h5", "end as timeout");
  // Any other outcome is what somebody says.
  cut.info.outcome = Outcome::interrupted;
  write_episode(folder / "interrupted.h5", cut);
  EXPECT_EQ(read_episode(folder / "interrupted.h5").rows, cut.rows);
}

}  // namespace
}  // namespace ferrule
