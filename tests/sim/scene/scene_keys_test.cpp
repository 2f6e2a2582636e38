#include "sim/scene/scene_keys.hpp"

#include <gtest/gtest.h>

#include <set>

#include "sim/scene/draw.hpp"
#include "tests/compare.hpp"

namespace ferrule {
namespace {

Json schema() {
  const std::string file = FERRULE_SOURCE "/data/scenes/scene.schema.json";
  return parse_json(read_text(file), file);
}

// What the schema states of each key, itself and in all alternatives.
void add_parts(const Json& schema, const Json& part, const std::string& key,
               std::map<std::string, std::vector<Json>>& found) {
  if (part.contains("$ref")) {
    const Json at = schema.at(Json::json_pointer(part["$ref"].get<std::string>().substr(1)));
    return add_parts(schema, at, key, found);
  }
  found[key].push_back(part);
  for (const char* alternatives : {"anyOf", "oneOf"})
    for (const Json& each : part.value(alternatives, Json::array()))
      add_parts(schema, each, key, found);
  if (part.value("type", Json()) == "array")
    if (const Json& items = part.at("items"); items.is_object())
      add_parts(schema, items, key, found);
  const Json properties = part.value("properties", Json::object());
  for (const auto& [name, value] : properties.items())
    if (value.is_object() && name != "drawn_from")
      add_parts(schema, value, key.empty() ? name : key + "." + name, found);
}

bool is_distribution(const std::string& key) {
  for (const char* kind : {".normal", ".uniform", ".lognormal", ".choice"})
    if (key.ends_with(kind)) return true;
  return false;
}

TEST(SceneKeys, TheSchemaStatesTheSameKeysRangesAndRemarks) {
  std::map<std::string, std::vector<Json>> stated;
  const Json whole = schema();
  add_parts(whole, whole, "", stated);
  std::set<std::string> known;
  for (const SceneKey& key : scene_keys()) {
    known.insert(key.name);
    ASSERT_TRUE(stated.contains(key.name)) << key.name;
    std::string about;
    bool drawn = false, ranged = false;
    for (const Json& part : stated[key.name]) {
      about += part.value("description", "");
      drawn = drawn || part.value("description", "").starts_with("A number that chance decides");
      const Json type = part.value("type", Json());
      if (type != "number" && type != "integer") continue;
      ranged = true;
      const bool open = part.contains("exclusiveMaximum") || part.contains("exclusiveMinimum");
      EXPECT_EQ(part.value("minimum", part.value("exclusiveMinimum", -HUGE_VAL)), key.rule.low)
          << key.name;
      EXPECT_EQ(part.value("maximum", part.value("exclusiveMaximum", HUGE_VAL)), key.rule.high)
          << key.name;
      EXPECT_EQ(open, key.rule.low_open || key.rule.high_open) << key.name;
      EXPECT_EQ(type == "integer", key.rule.whole) << key.name;
    }
    EXPECT_EQ(ranged, key.numeric()) << key.name;
    EXPECT_EQ(drawn, key.numeric() && key.chance.may) << key.name;
    EXPECT_TRUE(about.starts_with(key.about)) << key.name << ": " << about;
    EXPECT_EQ(about.empty() || about.starts_with("A number that chance"), !*key.about) << key.name;
  }
  for (const auto& [key, parts] : stated)
    EXPECT_TRUE(known.contains(key) || key.empty() || key == "$schema" || is_distribution(key))
        << key << " is no key of a scene";
}

// A number that is set gives what a file gives that states it, whatever follows from it.
TEST(SceneKeys, ANumberThatIsDrawnGivesTheSceneOfItsDocument) {
  for (const char* name : {"bench", "epoxy", "tolerance", "adhesive"}) {
    const Json document = load_scene(name).document();
    int compared = 0;
    for (const SceneKey& key : scene_keys()) {
      const Json::json_pointer at = pointer_to(key.name);
      if (!key.numeric() || !key.chance.may || !document.contains(at) ||
          !document.at(at).is_number())
        continue;
      const double value = document.at(at);
      Json varied = document;
      varied[at] = {{"choice", {value, value * (1 + 1e-6), value * (1 - 1e-6)}}};
      const Scene scene = parse_scene(varied, name);
      const auto drawn = draw_scene(scene, 4, 2);
      ASSERT_TRUE(drawn) << name << " " << key.name;
      const Scene again = parse_scene(drawn->document(), name);
      const State start = draw_start(*drawn, 4, 2), same = draw_start(again, 4, 2);
      EXPECT_EQ(start.tip, same.tip) << name << " " << key.name;
      EXPECT_EQ(drawn->limits.force, again.limits.force) << name << " " << key.name;
      const Numerics &a = drawn->world.numerics, &b = again.world.numerics;
      EXPECT_EQ(a.extrapolation_tip, b.extrapolation_tip) << name << " " << key.name;
      EXPECT_EQ(a.extrapolation_force, b.extrapolation_force) << name << " " << key.name;
      EXPECT_EQ(again.document(), drawn->document()) << name << " " << key.name;
      EXPECT_EQ(undrawn(drawn->document()), varied) << name << " " << key.name;
      ++compared;
    }
    EXPECT_GT(compared, 25) << name;
  }
}

TEST(SceneKeys, AnElementOfAListIsSetWhereItStands) {
  Scene scene = load_scene("bench");
  EXPECT_TRUE(set_number(scene, "start.lateral_mean_um.1", 3));
  EXPECT_CLOSE(scene.start.lateral_mean.y(), 3e-6, 1e-15);
  EXPECT_CLOSE(scene.start.lateral.y(), 3e-6, 1e-15);
  EXPECT_FALSE(set_number(scene, "start.lateral_mean_um.1", 1e7));
  EXPECT_FALSE(set_number(scene, "start.lateral_mean_um.y", 1));
  EXPECT_FALSE(set_number(scene, "fibre.colour", 1));
  EXPECT_FALSE(set_number(scene, "quadrature", 4.5));
  EXPECT_TRUE(set_number(scene, "quadrature", 4));
  EXPECT_EQ(scene.parameters.numerics.quadrature.order, 4);
}

}  // namespace
}  // namespace ferrule
