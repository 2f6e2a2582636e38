#include "learn/demonstrations.hpp"

#include "tests/compare.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

// `rows` rows 10 ms apart, that nobody keeps.
EpisodeRows long_episode(Eigen::Index rows, Outcome outcome = Outcome::inserted) {
  EpisodeInfo info;
  info.scene = load_scene("demo").document().dump();
  info.period = kStep;
  info.outcome = outcome;
  return {info, rows, [](Eigen::Index, Eigen::Index count) -> EpisodeRows::Part {
            return {Rows::Zero(count, kRowSize), {}};
          }};
}

std::string kept(const DemonstrationSet& set) {
  std::string hashes;
  for (const Demonstration& d : set.demonstrations) hashes += d.sha1;
  return hashes;
}

TEST(DemonstrationSet, OfTooManyRowsThoseStayWhoseHashesAreSmallestInWhateverOrderTheyCome) {
  for (const std::string order : {"abcdefg", "gfedcba", "dgaebfc"}) {
    DemonstrationSet set;
    for (const char hash : order) set.add(long_episode(100'000), "file", std::string(1, hash));
    std::string hashes = kept(set);
    std::sort(hashes.begin(), hashes.end());
    EXPECT_EQ(hashes, "abcd");
    EXPECT_EQ(set.rows(), DemonstrationSet::kMostRows);
    EXPECT_EQ(set.beyond, 3U);
    EXPECT_EQ(set.operators.size(), 7U);
  }
}

TEST(DemonstrationSet, AsManyStayAsAFitNeedsHoweverLongTheyAre) {
  DemonstrationSet set;
  for (const char hash : {'c', 'b', 'a', 'd'})
    set.add(long_episode(150'000), "file", std::string(1, hash));
  EXPECT_EQ(kept(set), "cba");
  EXPECT_NO_THROW(refuse_too_few(set));
}

TEST(DemonstrationSet, UnsuccessfulOnesTakeNoRows) {
  DemonstrationSet set;
  for (int k = 0; k < 5; ++k)
    set.add(long_episode(150'000, k < 3 ? Outcome::timeout : Outcome::inserted), "file",
            std::to_string(k));
  EXPECT_EQ(kept(set), "34");
  EXPECT_EQ(set.unsuccessful, 3U);
  EXPECT_EQ(set.beyond, 0U);
}

}  // namespace
}  // namespace ferrule
