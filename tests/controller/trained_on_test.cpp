#include "controller/trained_on.hpp"

#include <gtest/gtest.h>

namespace ferrule {
namespace {

TrainedOn read_back(const Json& trained) {
  const Json document = {{"trained_on", trained}};
  JsonFields fields(document, "law.json");
  return read_trained_on(fields, "law.json");
}

TEST(TrainedOn, IsReadBack) {
  const Scene scene = load_scene("bench");
  TrainedOn t;
  t.scenes = {"bench"};
  t.episodes = {{"a.h5", "12ab", 3, 5}};
  t.held_out = {{"b.h5", "34cd", 3, std::uint64_t{1} << 32}};
  t.rows = 7;
  t.seed = 2;
  t.rollouts = 30;
  t.partial = true;
  t.scaling = Scaling{1.0 / 3, 12345.678};
  t.speed_limit = scene.limits.speed;
  t.force_limit = scene.limits.force;
  t.scene = scene.document();
  const TrainedOn back = read_back(Json::parse(to_json(t).dump()));
  EXPECT_EQ(back.episodes, t.episodes);
  EXPECT_EQ(back.held_out, t.held_out);
  EXPECT_EQ(back.rollouts, t.rollouts);
  EXPECT_TRUE(back.partial);
  ASSERT_TRUE(back.scaling.has_value());
  EXPECT_EQ(back.scaling->motion, t.scaling->motion);
  EXPECT_EQ(back.scaling->force, t.scaling->force);
  EXPECT_DOUBLE_EQ(back.speed_limit, t.speed_limit);
  EXPECT_DOUBLE_EQ(back.force_limit, t.force_limit);
  EXPECT_EQ(back.scene, t.scene);
}

TEST(TrainedOn, FilesOfBeforeStateLess) {
  const TrainedOn old = read_back(Json::parse(
      R"({"scenes": ["demo"], "episodes": [{"file": "a.h5", "sha1": "12"}], "held_out": [],
          "rows": 7, "seed": 1})"));
  EXPECT_FALSE(old.scaling.has_value());
  EXPECT_FALSE(old.episodes.at(0).seed.has_value());
  EXPECT_TRUE(old.scene.is_null());
  EXPECT_FALSE(old.partial);
}

TEST(TrainedOn, RefusesWhatIsNoSceneOrScaling) {
  for (const char* wrong :
       {R"("scene": {"name": "x"})", R"("scaling": {"alpha_x": 0, "alpha_f": 1})",
        R"("partial": 1)", R"("surprise": 1)"})
    EXPECT_THROW(
        read_back(Json::parse(
            std::string(
                R"({"scenes": [], "episodes": [], "held_out": [], "rows": 7, "seed": 1, )") +
            wrong + "}")),
        BadInput)
        << wrong;
}

}  // namespace
}  // namespace ferrule
