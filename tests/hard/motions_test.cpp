// Motions that once went wrong, each in a file that says how (tests/hard/motions): the hand goes in
// straight lines, and back to where it began.
#include <gtest/gtest.h>

#include <filesystem>
#include <vector>

#include "sim/base/json_file.hpp"
#include "sim/scene/draw.hpp"
#include "tests/hard/follow.hpp"

namespace ferrule {
namespace {

struct RecordedCase {
  Scene scene;
  double period = 0;  // [s]
  State start;
  std::vector<Pose> hand;
};

Pose pose(const Json& numbers) {
  Pose read;
  for (int i = 0; i < 5; ++i) read[i] = numbers.at(static_cast<std::size_t>(i));
  return read;
}

// "start": where the tip would be in free air. "hand": [steps, pose], to there in so many steps.
// Poses are [x, y, z, tilt_y, tilt_z] in [m] and [rad].
RecordedCase load_case(const std::filesystem::path& file) {
  return read_json(file.string(), [&](const Json& json) {
    RecordedCase read{parse_scene(json.at("scene"), file.string()), json.at("period_s"), {}, {}};
    read.start = start_at(read.scene.world, pose(json.at("start")));
    Pose from = read.start.command;
    read.hand.push_back(from);
    for (const Json& corner : json.at("hand")) {
      const int steps = corner.at(0);
      const Pose to = pose(corner.at(1));
      for (int n = 1; n <= steps; ++n) read.hand.push_back(from + (to - from) * n / steps);
      from = to;
    }
    read.hand.back() = read.start.command;  // closed to the last bit
    return read;
  });
}

TEST(RecordedMotions, BoundTheWorkOfAStepAndGainNoEnergy) {
  int cases = 0;
  for (const auto& file :
       std::filesystem::directory_iterator(FERRULE_SOURCE "/tests/hard/motions")) {
    SCOPED_TRACE(file.path().filename());
    const RecordedCase motion = load_case(file.path());
    ASSERT_GT(motion.hand.size(), 100U);
    long unfinished = 0;
    ASSERT_NO_FATAL_FAILURE(
        testing::follow(motion.scene.world, motion.start, motion.hand, motion.period, unfinished));
    ++cases;
  }
  EXPECT_GT(cases, 0);
}

}  // namespace
}  // namespace ferrule
