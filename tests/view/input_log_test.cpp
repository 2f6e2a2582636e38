#include "view/input_log.hpp"

#include <gtest/gtest.h>

#include "insertion/scene_scaling.hpp"
#include "sim/base/control_period.hpp"
#include "sim/scene/draw.hpp"
#include "tests/episodes.hpp"
#include "view/browser_device.hpp"

namespace ferrule {
namespace {

RawCounts counts(int x, int y, int z) {
  RawCounts all = RawCounts::Zero();
  all.head<3>() << x, y, z;
  return all;
}

InputLog example() {
  InputLog log;
  log.info.scene = load_scene("easy").document().dump();
  log.info.seed = 1;
  log.info.trial = 2;
  log.info.operator_ = "Ada, browser";
  log.info.trainee = "Ada";
  log.info.version = "0.9.1";
  log.info.build = "a browser";
  log.info.outcome = Outcome::stopped_short;
  log.rows_sha1 = std::string(40, 'a');
  for (int n = 0; n < 30; ++n) log.add(counts(0, 0, 0));
  for (int n = 0; n < 20; ++n) log.add(counts(-10000, 7, 0));
  log.add(counts(0, 0, -3));
  return log;
}

TEST(InputLog, RowsWithTheSameCountsAreOneEntry) {
  const InputLog log = example();
  ASSERT_EQ(log.held.size(), 3u);
  EXPECT_EQ(log.held[1].rows, 20);
  EXPECT_EQ(log.rows(), 51);
}

TEST(InputLog, IsReadAsItWasWritten) {
  const InputLog log = example();
  const InputLog read = parse_input_log(Json::parse(to_json(log).dump()), "try.json");
  EXPECT_EQ(to_json(read), to_json(log));
  EXPECT_EQ(read.info.outcome, Outcome::stopped_short);
  EXPECT_EQ(read.rows_sha1, log.rows_sha1);
}

// The hand of the page, told the same counts at the same times, and finished after the last row.
TEST(InputLog, ItsHandIsThatOfThePage) {
  const InputLog log = example();
  const Scene scene = recorded_scene(log.info, "try.json");
  const State start = draw_start(scene, log.info.seed, log.info.trial);
  const std::unique_ptr<Device> hand = logged_hand(log, testing::setup(scene, start));
  HandPose pose = scene_scaling(scene).motion_to_hand(start.command);
  HandTwist rate = HandTwist::Zero();
  std::int64_t n = 0;
  for (const HeldCounts& held : log.held)
    for (std::int64_t i = 0; i < held.rows; ++i, ++n) {
      const HandSample sample = hand->read(kControlPeriod * static_cast<double>(n));
      pose += kControlPeriod * rate;
      EXPECT_LT((sample.pose - pose).norm(), 1e-12 * pose.norm());
      EXPECT_FALSE(sample.finished) << n;
      for (Eigen::Index axis = 0; axis < 3; ++axis)
        EXPECT_EQ(sample.counts[axis], held.counts[static_cast<std::size_t>(axis)]);
      rate = hand->mapping()->gain * hand->mapping()->deflection(sample.counts);
    }
  EXPECT_TRUE(hand->read(kControlPeriod * static_cast<double>(n)).finished);
}

TEST(InputLog, WhatIsNoneIsRefusedWithItsKey) {
  const auto refused = [](const char* key, const Json& value) {
    Json json = to_json(example());
    if (value.is_discarded())
      json.erase(key);
    else
      json[key] = value;
    try {
      parse_input_log(json, "try.json");
    } catch (const BadInput& error) {
      return std::string(error.what()).find(key) != std::string::npos;
    }
    return false;
  };
  const Json none(Json::value_t::discarded);
  for (const char* key : {"format", "scene", "seed", "counts", "outcome", "rows_sha1"})
    EXPECT_TRUE(refused(key, none)) << key;
  for (const Json& bad :
       {Json("x"), Json::array(), Json{{1, 2, 3}}, Json{{0, 0, 0, 0}}, Json{{1, 10001, 0, 0}},
        Json{{1, 0.5, 0, 0}}, Json{{std::int64_t{1} << 40, 0, 0, 0}}, Json{{1, 0, 0, 0, 0}},
        Json{{86399999, 0, 0, 0}, {2, 0, 0, 0}}, Json{{1, "1", 0, 0}}})
    EXPECT_TRUE(refused("counts", bad)) << bad;
  EXPECT_TRUE(refused("format", "ferrule episode"));
  EXPECT_TRUE(refused("format_version", 2));
  EXPECT_TRUE(refused("outcome", "won"));
  EXPECT_TRUE(refused("seed", -1));
  EXPECT_TRUE(refused("trainee", "two\nlines"));
  EXPECT_TRUE(refused("a key that nobody knows", 1));
}

}  // namespace
}  // namespace ferrule
