#include "sim/scene/terms.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "sim/analysis/gap_forces.hpp"
#include "sim/solver/step.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

// The table, the schema that editors use, and what a scene may hold are the same list.
TEST(Terms, SchemaAndTableNameTheSameLaws) {
  const Json schema = parse_json(read_text(FERRULE_SOURCE "/data/scenes/scene.schema.json"), "");
  std::set<std::string> in_schema, in_table;
  for (const auto& [name, law] : schema.at("properties").at("laws").at("properties").items()) {
    in_schema.insert(name);
    const Json& form = law.at("properties").at("form");
    const auto term = std::find(kTermNames.begin(), kTermNames.end(), name);
    ASSERT_NE(term, kTermNames.end()) << name;
    EXPECT_EQ(info(static_cast<Term>(term - kTermNames.begin())).printed, form.contains("enum"))
        << name;
  }
  for (const Term term : kAllTerms)
    if (info(term).read) in_table.insert(info(term).name);
  EXPECT_EQ(in_schema, in_table);
}

TEST(Terms, WhatIsLeftOutIsNotThereAndExertsNoForce) {
  for (const char* name : {"paper", "bench", "film", "epoxy", "adhesive"}) {
    const Scene scene = load_scene(name);
    for (const Term term : kAllTerms) {
      if (!info(term).present(scene.world.laws)) continue;
      WorldParameters parameters = scene.parameters;
      info(term).leave_out(parameters.laws);
      World world = make_world(parameters);
      if (term == Term::wall) world.laws.wall.reset();  // follows from the others
      EXPECT_FALSE(info(term).present(world.laws)) << name << " " << info(term).name;
      const GapForces at_gap = gap_forces(world, {5e-9, 50e-6, 2e-9, 0, 1e-5});
      EXPECT_EQ(at_gap[term], 0) << name << " " << info(term).name;
      const State pressed =
          at_rest(world, testing::pose(-50e-6, world.annulus.clearance() + 5e-9, 0));
      const StepResult r = step(world, pressed, pressed.command, 1e-3);
      EXPECT_EQ(forces(world, r).force(term).norm(), 0) << name << " " << info(term).name;
    }
  }
}

TEST(VariableScene, ANumberThatIsSetGivesTheWorldOfAFileThatStatesIt) {
  for (const char* name : {"paper", "bench", "film", "epoxy", "adhesive", "tolerance"}) {
    const Scene scene = load_scene(name);
    const Json flat = scene.document().flatten();
    VariableScene varied(scene);
    int compared = 0;
    for (const auto& [pointer, value] : flat.items()) {
      std::string key = pointer.substr(1);
      std::replace(key.begin(), key.end(), '/', '.');
      if (!varied.number(key)) continue;
      EXPECT_EQ(*varied.number(key), value.get<double>()) << name << " " << key;
      Json document = scene.document();
      const double changed = value.get<double>() * (1 + 1e-5);
      document[Json::json_pointer(pointer)] = changed;
      varied.set(key, changed);
      ASSERT_TRUE(varied.consistent()) << name << " " << key;
      const World expected = parse_scene(document, name).world, world = varied.world();
      const State start = at_rest(expected, testing::pose(-20e-6, 2e-7, 1e-7));
      const StepResult a = step(expected, start, start.command, 1e-3);
      const StepResult b = step(world, start, start.command, 1e-3);
      EXPECT_EQ(to_row(a.state), to_row(b.state)) << name << " " << key;
      EXPECT_EQ(a.holder, b.holder) << name << " " << key;
      EXPECT_EQ(world.profile.lead_in_length, expected.profile.lead_in_length) << key;
      varied.set(key, value.get<double>());
      ++compared;
    }
    EXPECT_GT(compared, 25) << name;
  }
}

TEST(VariableScene, KnowsWhichNumbersAreNoScene) {
  const Scene scene = load_scene("bench");
  VariableScene varied(scene);
  EXPECT_FALSE(varied.number("laws"));
  EXPECT_FALSE(varied.number("fibre.colour"));
  EXPECT_TRUE(varied.consistent());
  const double bore = *varied.number("ferrule.bore_diameter_um");
  varied.set("ferrule.bore_diameter_um", *varied.number("fibre.diameter_um"));
  EXPECT_FALSE(varied.consistent()) << "no clearance";
  varied.set("ferrule.bore_diameter_um", bore);
  varied.set("limits.force_uN", -1);
  EXPECT_FALSE(varied.consistent()) << "out of its range";
}

}  // namespace
}  // namespace ferrule
