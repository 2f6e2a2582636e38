#include "sim/scene/draw.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <set>

#include "tests/compare.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

constexpr std::uint64_t kDraws = 2000;

// Fibres of that tolerance, in a bore that all of them fit.
std::vector<double> fibres(const std::string& tolerance) {
  const Scene scene =
      testing::bare({"ferrule.bore_diameter_um=130", "fibre.diameter_um=" + tolerance});
  std::vector<double> um;
  for (std::uint64_t trial = 0; trial < kDraws; ++trial)
    um.push_back(draw_scene(scene, 1, trial)->parameters.fibre.diameter_um);
  std::sort(um.begin(), um.end());
  return um;
}

// The largest distance of the empirical distribution from `cdf` is below Kolmogorov's 0.1 % point.
template <class Cdf>
void expect_distributed(const std::vector<double>& sorted, const Cdf& cdf) {
  const auto n = static_cast<double>(sorted.size());
  double largest = 0;
  for (std::size_t i = 0; i < sorted.size(); ++i)
    largest = std::max(largest, std::abs(cdf(sorted[i]) - (static_cast<double>(i) + 0.5) / n));
  EXPECT_LT(largest, 1.95 / std::sqrt(n));
}

TEST(Draw, ANumberIsLogNormal) {
  const Scene scene =
      testing::bare({R"(laws.friction={"form":"corrected","burgers_nm":{"lognormal":[0.2,0.4]}})"});
  std::vector<double> nm;
  for (std::uint64_t trial = 0; trial < kDraws; ++trial)
    nm.push_back(
        draw_scene(scene, 1, trial)->document()["laws"]["friction"]["burgers_nm"].get<double>());
  std::sort(nm.begin(), nm.end());
  EXPECT_GE(nm.front(), 0.2 * std::exp(-1.2) * (1 - 1e-12));
  EXPECT_LE(nm.back(), 0.2 * std::exp(1.2) * (1 + 1e-12));
  expect_distributed(nm,
                     [](double x) { return 0.5 * std::erfc(-std::log(x / 0.2) / 0.4 / M_SQRT2); });
}

TEST(Draw, EachOfAChoiceIsAsLikely) {
  const Scene scene = testing::bare({R"(quadrature={"choice":[3,5,8]})"});
  EXPECT_EQ(scene.parameters.numerics.quadrature.order, 3);  // the first one
  std::map<int, int> counts;
  for (std::uint64_t trial = 0; trial < kDraws; ++trial)
    ++counts[draw_scene(scene, 1, trial)->parameters.numerics.quadrature.order];
  ASSERT_EQ(counts.size(), 3u);
  for (const auto& [nodes, count] : counts)  // five standard deviations
    EXPECT_NEAR(count, kDraws / 3.0, 5 * std::sqrt(kDraws * 2.0 / 9)) << nodes;
}

// Whatever else is drawn, and in whichever order it stands in the file.
TEST(Draw, ANumberDependsOnSeedTrialAndKeyAlone) {
  const std::vector<std::string> all = {
      "fibre.diameter_um=125+-0.3", "start.distance_um=20..40", "limits.time_s=5..6",
      R"(start.lateral_mean_um=[{"uniform":[-1,1]},0])", "roughness_nm=8..12"};
  const Json together = draw_scene(testing::bare(all), 5, 9)->document();
  for (const std::string& one : all) {
    const Json alone = draw_scene(testing::bare({one}), 5, 9)->document();
    const auto at = pointer_to(one.substr(0, one.find('=')));
    EXPECT_EQ(alone.at(at), together.at(at)) << one;
    EXPECT_NE(alone.at(at), draw_scene(testing::bare({one}), 6, 9)->document().at(at)) << one;
    EXPECT_NE(alone.at(at), draw_scene(testing::bare({one}), 5, 10)->document().at(at)) << one;
  }
}

// Two keys with one generator would be drawn alike.
TEST(Draw, NoTwoKeysShareAGenerator) {
  const auto folder = std::filesystem::path(scene_file("demo")).parent_path();
  const Json schema = parse_json(read_text(folder / "scene.schema.json"), "");
  std::set<std::string> keys;
  const std::function<void(const Json&, const std::string&)> walk = [&](const Json& object,
                                                                        const std::string& path) {
    const Json properties = object.value("properties", Json::object());
    for (const auto& [name, part] : properties.items()) {
      keys.insert(path + name);
      walk(part, path + name + ".");
    }
    for (const Json& each : object.value("oneOf", Json::array())) walk(each, path);
  };
  walk(schema, "");
  std::set<std::uint64_t> first;
  for (const std::string& key : keys) first.insert(RandomStream(1, 2, key).bits());
  EXPECT_GT(keys.size(), 100u);
  EXPECT_EQ(first.size(), keys.size());
}

TEST(Draw, WhatIsDrawnMayBringFurtherChance) {
  const Scene scene = testing::bare({R"(sensor.entrance_sd_um={"choice":[0,5]})"});
  int with = 0;
  for (std::uint64_t trial = 0; trial < 100; ++trial) {
    const auto drawn = draw_scene(scene, 1, trial);
    EXPECT_TRUE(drawn->drawn.empty());
    with += drawn->sensor.entrance_error != 0;
    EXPECT_EQ(undrawn(drawn->document()), scene.document());
  }
  EXPECT_NEAR(with, 50, 25);
}

// At either end of what may be drawn.
TEST(Draw, WhatAKeyMustNotBeIsRefusedBeforeItIsDrawn) {
  for (const auto& [setting, says] :
       {std::pair(
            "start.lateral_sd_um=1+-2",
            "start.lateral_sd_um = {\"normal\":[1,0.6666666666666666]}: "
            "may be drawn as what it must not be: start.lateral_sd_um = -1: must not be negative"),
        {R"(quadrature={"choice":[5,99]})", "quadrature = 99: must be a whole number"},
        {R"(fibre.young_GPa={"normal":[72]})", "must be {\"normal\": [mean, standard deviation]}"},
        {R"(fibre.young_GPa={"uniform":[3,2]})", "must be {\"uniform\": [low, high]}"},
        {R"(fibre.young_GPa={"lognormal":[0,1]})", "median > 0"},
        {R"(fibre.young_GPa={"choice":[]})", "must be {\"choice\": [number, ...]}"},
        {R"(fibre.young_GPa={"beta":[1,2]})", "must be a number"},
        {R"(name={"choice":[1]})", "must be a text"},
        {"step_s=1e-4..1e-3", "must be a number, the same in all trials"}})
    try {
      testing::bare({setting});
      ADD_FAILURE() << setting;
    } catch (const BadInput& error) {
      EXPECT_NE(std::string(error.what()).find(says), std::string::npos) << error.what();
    }
}

TEST(Draw, PartsThatCannotBeTogetherAreInfeasible) {
  const Scene scene = testing::bare({"ferrule.bore_diameter_um=124.5..126.5"});
  int infeasible = 0;
  for (std::uint64_t trial = 0; trial < kDraws; ++trial) infeasible += !draw_scene(scene, 1, trial);
  EXPECT_NEAR(infeasible, kDraws / 4.0, 5 * std::sqrt(kDraws * 3.0 / 16));
}

// In the middle fibre and bore are both 126 um wide.
TEST(Draw, CentresThatCannotBeTogetherGiveWayToATrialThatCan) {
  const Scene scene =
      testing::bare({"fibre.diameter_um=125..127", "ferrule.bore_diameter_um=125.5..126.5"});
  const WorldParameters& p = scene.parameters;
  EXPECT_LT(p.fibre.diameter_um, p.ferrule.bore_diameter_um);
  EXPECT_GE(p.fibre.diameter_um, 125);
  EXPECT_LE(p.ferrule.bore_diameter_um, 126.5);
  std::size_t feasible = 0;
  for (std::uint64_t trial = 0; trial < kDraws; ++trial)
    feasible += draw_scene(scene, 1, trial) != nullptr;
  EXPECT_NEAR(static_cast<double>(feasible) / kDraws, 0.5, 0.04);  // half of the rectangle
  EXPECT_THROW(testing::bare({"fibre.diameter_um=127..128", "ferrule.bore_diameter_um=126..126.9"}),
               BadInput);
}

TEST(Draw, AFibreBetweenTwoDiametersIsUniform) {
  const std::vector<double> um = fibres("124.25..125");
  EXPECT_GE(um.front(), 124.25 - 1e-9);
  EXPECT_LE(um.back(), 125 + 1e-9);
  expect_distributed(um, [](double x) { return (x - 124.25) / 0.75; });
}

TEST(Draw, AFibreAboutADiameterIsNormal) {
  const std::vector<double> um = fibres("125+-0.75");
  EXPECT_GE(um.front(), 124.25 - 1e-9);
  EXPECT_LE(um.back(), 125.75 + 1e-9);
  expect_distributed(um, [](double x) { return 0.5 * std::erfc(-(x - 125) / 0.25 / M_SQRT2); });
}

// In y and in z, with the variance of both parts: fibre 0.3, ferrule 0.4 um.
TEST(Draw, ACoreIsOffByWhatFibreAndFerruleAre) {
  const Scene scene =
      testing::bare({"joint.core_concentricity_sd_um=0.3", "joint.bore_concentricity_sd_um=0.4"});
  for (const char* along : {"y", "z"}) {
    std::vector<double> um;
    for (std::uint64_t trial = 0; trial < kDraws; ++trial)
      um.push_back(draw_scene(scene, 1, trial)->joint.offset[*along - 'y'] * 1e6);
    std::sort(um.begin(), um.end());
    expect_distributed(um, [](double x) { return 0.5 * std::erfc(-x / 0.5 / M_SQRT2); });
  }
  const auto drawn = draw_scene(scene, 1, 3);
  const Scene again = parse_scene(drawn->document(), "drawn");
  EXPECT_EQ(again.joint.offset, drawn->joint.offset);
  EXPECT_EQ(draw_scene(again, 1, 4)->joint.offset, drawn->joint.offset);
  EXPECT_EQ(undrawn(again.document()), scene.document());
}

TEST(Draw, ADrawnPairStatesWhatItWasDrawnFrom) {
  const Scene scene =
      testing::paper({"ferrule.bore_diameter_um=126..127", "fibre.diameter_um=125+0/-0.5"});
  const auto drawn = draw_scene(scene, 1, 3);
  const Scene again = parse_scene(drawn->document(), "drawn");
  EXPECT_TRUE(again.drawn.empty());
  EXPECT_EQ(again.document()["drawn_from"]["was"]["fibre.diameter_um"],
            (Json{{"uniform", {124.5, 125}}}));
  EXPECT_EQ(again.world.annulus.fibre_radius, drawn->world.annulus.fibre_radius);
  EXPECT_EQ(again.world.annulus.bore_radius, drawn->world.annulus.bore_radius);
  EXPECT_EQ(undrawn(again.document()), scene.document());
}

// One thing again, all else as it was.
TEST(Draw, WhatIsDrawnAgainAloneChanges) {
  const Scene scene =
      load_scene("bench", {"ferrule.bore_diameter_um=126..127", "fibre.cleave_deg=0.3..0.6"});
  const auto all = [&](const std::string& redrawn) {
    const auto drawn = draw_scene(scene, 3, 5, redrawn);
    const State start = draw_start(*drawn, 3, 5);
    Eigen::Matrix<double, 8, 1> numbers;
    numbers << start.tip, drawn->parameters.ferrule.bore_diameter_um,
        *drawn->parameters.fibre.cleave_deg, *drawn->parameters.fibre.roll_deg;
    return numbers;
  };
  const auto as_it_is = all("");
  const std::vector<std::pair<std::string, std::vector<int>>> changed = {
      {"start.lateral_sd_um", {1, 2}},   {"start.tilt_sd_mrad", {3, 4}},
      {"ferrule.bore_diameter_um", {5}}, {"fibre.cleave_deg", {6}},
      {"fibre.roll_deg", {7}},           {"sensor", {}}};
  for (const auto& [key, places] : changed) {
    const auto again = all(key);
    for (int i = 0; i < 8; ++i)
      EXPECT_EQ(again[i] == as_it_is[i], std::find(places.begin(), places.end(), i) == places.end())
          << key << ", " << i;
  }
}

}  // namespace
}  // namespace ferrule
