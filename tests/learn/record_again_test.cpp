#include "learn/record_again.hpp"

#include <gtest/gtest.h>

#include "controller/searching_operator.hpp"
#include "tests/episodes.hpp"
#include "tests/temporary_folder.hpp"

namespace ferrule {
namespace {

const std::vector<std::string> kQuick = {"start.distance_um=10", "success.depth_um=8",
                                         "limits.speed_um_s=20"};

// Under the seed that the episodes were recorded with, it gives them back.
TEST(RecordAgain, IsTheRecordingOfThatSeed) {
  const testing::TemporaryFolder folder;
  const Scene scene = load_scene("paper", kQuick);
  for (const std::uint64_t trial : {1, 2, 3}) {
    const std::string file = testing::record(scene, folder.path(), trial);
    Episode episode = read_episode(file);
    episode.info.operator_ = SimulatedOperator{0.8}.name();
    std::filesystem::remove(file);
    write_episode(file, episode);
  }
  const DemonstrationSet set = load_demonstrations(folder.path());
  const DemonstrationSet again = record_again(set, 1), other = record_again(set, 2);
  ASSERT_EQ(again.demonstrations.size(), set.demonstrations.size());
  for (std::size_t i = 0; i < set.demonstrations.size(); ++i)
    EXPECT_EQ(again.demonstrations[i].velocity, set.demonstrations[i].velocity);
  EXPECT_EQ(again.speed_scale, set.speed_scale);
  EXPECT_EQ(again.documents, set.documents);
  ASSERT_FALSE(other.demonstrations.empty());
  EXPECT_FALSE(other.demonstrations[0].velocity.row(0) == set.demonstrations[0].velocity.row(0) &&
               other.demonstrations[0].velocity.rows() == set.demonstrations[0].velocity.rows());
}

TEST(RecordAgain, AsksNobodyButSimulatedOperators) {
  const testing::TemporaryFolder folder;
  testing::record(load_scene("paper", kQuick), folder.path(), 1);  // by "test"
  EXPECT_THROW(record_again(load_demonstrations(folder.path()), 1), BadInput);
}

TEST(SimulatedOperator, HasANameThatTellsHisSkill) {
  for (const double skill : {0.0, 0.05, 0.8, 1.0 / 3, 1.0})
    for (const bool searches : {false, true}) {
      const auto same = SimulatedOperator::named(SimulatedOperator{skill, searches}.name()).value();
      EXPECT_EQ(same.skill.traits().tremor, trainee_traits(skill).tremor);
      EXPECT_EQ(same.searches, searches);
    }
  for (const char* name :
       {"", "pen 1234:5678", "simulated", "simulated, skill ", "simulated, skill 2",
        "simulated, skill 0.5x", "simulated, skill 0.5,", "controller simulated, skill 0.5"})
    EXPECT_FALSE(SimulatedOperator::named(name).has_value()) << name;
  EXPECT_EQ((SimulatedOperator{0.9, true}.name()), "searching, skill 0.9");
}

}  // namespace
}  // namespace ferrule
