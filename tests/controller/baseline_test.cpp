#include "controller/baseline.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "insertion/scene_scaling.hpp"
#include "sim/scene/scene.hpp"
#include "tests/temporary_folder.hpp"

namespace ferrule {
namespace {

HandTwist first_command(const char* name, const Scene& scene) {
  return baseline(name, scene, 7)(0)->command({HandWrench::Zero(), 0, 0});
}

TEST(Baseline, GoesStraightAsFastAsItsSceneLetsIt) {
  for (const char* setting : {"limits.speed_um_s=20", "limits.speed_um_s=5"}) {
    const Scene scene = load_scene("bench", {setting});
    const double speed = scene_scaling(scene).motion * scene.limits.speed;
    const HandTwist straight = first_command(kStraight, scene),
                    spiral = first_command(kSpiral, scene);
    EXPECT_DOUBLE_EQ(straight[0], -speed);
    EXPECT_TRUE(straight.tail<4>().isZero(0));
    EXPECT_LT(spiral[0], 0);  // it comes down more slowly: it turns as well
    EXPECT_GE(spiral[0], -speed);
  }
}

TEST(Baseline, TheOperatorWhoSearchesIsHimselfInEveryTrial) {
  const Scene scene = load_scene("by_hand/sharp");
  const auto course = [&](std::uint64_t seed, std::uint64_t trial) {
    const auto controller = baseline(kSearching, scene, seed)(trial);
    HandTwist sum = HandTwist::Zero();
    for (int n = 0; n < 2000; ++n)
      sum += controller->command({HandWrench::Zero(), 0, 1e-3 * n, HandPose::Zero(), 1});
    return sum;
  };
  EXPECT_EQ(course(7, 3), course(7, 3));
  EXPECT_NE(course(7, 3), course(7, 4));
  EXPECT_NE(course(7, 3), course(8, 3));
}

TEST(Baseline, IsTheFileOfItsNameWhereThereIsOne) {
  for (const std::string& name : baseline_names()) EXPECT_TRUE(is_baseline(name));
  EXPECT_FALSE(is_baseline("search"));
  EXPECT_FALSE(is_baseline("constant_velocity"));
  const auto before = std::filesystem::current_path();
  const testing::TemporaryFolder folder;
  std::filesystem::current_path(folder.path());
  std::ofstream("spiral") << "{}";
  EXPECT_FALSE(is_baseline("spiral"));
  EXPECT_TRUE(is_baseline("constant-velocity"));
  std::filesystem::current_path(before);
}

}  // namespace
}  // namespace ferrule
