#include "sim/geometry/curl.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <numbers>

#include "sim/analysis/plan.hpp"
#include "sim/scene/draw.hpp"
#include "tests/compare.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

Scene curled(std::vector<std::string> settings = {}) {
  settings.insert(settings.begin(), "fibre.curl_radius_m=4");
  return load_scene("bench", settings);
}

// The arc of a circle, its slope integrated along it.
TEST(Curl, IsWhereAnArcEnds) {
  for (const double radius : {0.5, 4.0, 30.0})
    for (const double length : {3e-3, 10e-3, 50e-3}) {
      constexpr int kParts = 20000;
      double aside = 0, angle = 0;
      for (int n = 0; n < kParts; ++n) {
        const double part = length / kParts;
        aside += part * std::sin(angle + 0.5 * part / radius);
        angle += part / radius;
      }
      const Pose end = curl(radius, length, Vector2d::UnitX());
      const double slope = length / radius;
      EXPECT_CLOSE(end[1], aside, slope * slope);
      EXPECT_CLOSE(-end[3], std::tan(angle), slope * slope);
      EXPECT_EQ(end[0], 0);
    }
}

TEST(Curl, BendsACantileverAsAMomentAtItsEndDoes) {
  const World world = load_scene("bench").world;
  const double r = world.annulus.fibre_radius, radius = 4;
  const double EI = world.fibre_young * std::numbers::pi / 4 * r * r * r * r;
  const Vector2d direction(0.6, -0.8);
  const Wrench held = world.holder.stiffness * curl(radius, world.holder.free_length, direction);
  const double moment = EI / radius;
  EXPECT_LT(held.head<3>().norm(), 1e-9 * moment / world.holder.free_length);
  EXPECT_CLOSE(held[3], -moment * 0.6, 1e-12);
  EXPECT_CLOSE(held[4], moment * 0.8, 1e-12);
}

// The usual fibre: 12.5 um and 2.5 mrad at 10 mm; 32 uN at the end, free to tilt, push it back.
TEST(Curl, OfATelecomFibreIsFarMoreThanTheClearance) {
  const FreeCurl c = *free_curl(curled().parameters);
  EXPECT_CLOSE(c.aside, 12.5e-6, 1e-12);
  EXPECT_CLOSE(c.tilt, 2.5e-3, 1e-12);
  EXPECT_CLOSE(c.force, 32.4e-6, 5e-3);
  const Holder& holder = curled().world.holder;
  const Matrix2d plane{{holder.stiffness(1, 1), holder.stiffness(1, 3)},
                       {holder.stiffness(3, 1), holder.stiffness(3, 3)}};
  EXPECT_CLOSE(c.aside / plane.inverse()(0, 0), c.force, 1e-9);
  EXPECT_FALSE(free_curl(load_scene("bench").parameters));
}

TEST(Curl, TurnsWithTheRollAngleWhichChanceDecides) {
  const Scene straight = load_scene("bench"), scene = curled();
  Vector2d mean = Vector2d::Zero();
  constexpr int kTrials = 2000;
  for (std::uint64_t k = 0; k < kTrials; ++k) {
    const auto drawn = draw_scene(scene, 7, k);
    const State start = draw_start(*drawn, 7, k);
    EXPECT_EQ(start.tip, draw_start(scene, 7, k).tip);
    const Pose more = start.tip - draw_start(straight, 7, k).tip;
    EXPECT_CLOSE(more.segment<2>(1).norm(), 12.5e-6, 1e-9);
    EXPECT_CLOSE(more.tail<2>().norm(), 2.5e-3, 1e-9);
    const double roll = *drawn->parameters.fibre.roll_deg * std::numbers::pi / 180;
    EXPECT_LT((more.segment<2>(1) - 12.5e-6 * Vector2d(std::cos(roll), std::sin(roll))).norm(),
              1e-12);
    mean += more.segment<2>(1) / 12.5e-6 / kTrials;
  }
  // Of all directions: the mean of as many unit vectors.
  EXPECT_LT(mean.norm(), 4 / std::sqrt(kTrials));
  const Scene turned = curled({"fibre.roll_deg=90"});
  EXPECT_EQ(draw_scene(turned, 7, 1)->parameters.fibre.roll_deg, 90);
  const Pose more = draw_start(turned, 7, 1).tip - draw_start(straight, 7, 1).tip;
  EXPECT_CLOSE(more[2], 12.5e-6, 1e-9);
  EXPECT_LT(std::abs(more[1]), 1e-12);
}

TEST(Curl, ADrawnSceneSaysWhatItWasDrawnFromAndIsReadBack) {
  for (const Scene& scene :
       {curled(),
        curled({"tolerance.fibre_diameter_sd_um=0.1", "tolerance.bore_diameter_um=[125.8,126.2]"}),
        curled({"fibre.diameter_um=125+-0.3", "start.lateral_sd_um=1..2"})}) {
    const auto drawn = draw_scene(scene, 3, 5);
    EXPECT_EQ(undrawn(drawn->document()), scene.document());
    const Scene again = parse_scene(drawn->document(), "drawn");
    EXPECT_EQ(draw_start(again, 3, 5).tip, draw_start(scene, 3, 5).tip);
    EXPECT_EQ(draw_scene(again, 3, 5).get(), &again);
  }
}

TEST(Curl, IsLeftOutByAPlanWhereItDoesNotMatter) {
  for (const auto& [radius, kept] : {std::pair(4.0, true), std::pair(1e9, false)}) {
    const Scene scene = load_scene(
        "paper", {"fibre.curl_radius_m=" + std::to_string(radius), "laws.friction=null"});
    const Plan plan = make_plan(scene, 0.1);
    const auto curl = std::find_if(plan.terms.begin(), plan.terms.end(),
                                   [](const PlannedTerm& t) { return t.name == "curl"; });
    ASSERT_NE(curl, plan.terms.end());
    EXPECT_EQ(curl->kept, kept) << radius;
    EXPECT_EQ(plan.document["fibre"].contains("curl_radius_m"), kept);
  }
}

TEST(Curl, RefusesWhatIsNoSmallSlope) {
  for (const auto& [setting, rule] :
       {std::pair("fibre.curl_radius_m=0.05", "must be at least ten times the length"),
        std::pair("fibre.curl_radius_m=0", "must be positive"),
        std::pair("fibre.roll_deg=400", "must be from -360 to 360"),
        std::pair("drawn_from.added=[\"fibre.diameter_um\"]", "must be a list of keys")}) {
    const std::string key = std::string(setting).substr(0, std::string(setting).find('='));
    try {
      curled({setting});
      ADD_FAILURE() << setting;
    } catch (const BadInput& error) {
      EXPECT_NE(std::string(error.what()).find(key), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find(rule), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace ferrule
