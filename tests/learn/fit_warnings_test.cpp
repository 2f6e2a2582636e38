#include "learn/fit_warnings.hpp"

#include <gtest/gtest.h>

#include "insertion/scene_scaling.hpp"
#include "learn/fit_law.hpp"
#include "learn/record_again.hpp"

namespace ferrule {
namespace {

TEST(TimeWithoutForce, IsTheWayOverTheSpeed) {
  const Scene scene = load_scene("demo");
  const double motion = scene_scaling(scene).motion;
  const double way = scene.start.distance + scene.success.depth;
  for (const double share : {1.0, 0.5, 3.0}) {  // of the speed limit, which cuts the last
    const double speed = share * scene.limits.speed;
    const double time =
        time_without_force(controller_maker(ConstantVelocity(motion * speed)), scene);
    EXPECT_NEAR(time, way / std::min(speed, scene.limits.speed), 2e-3);
  }
  const double slow = 0.9 * way / scene.limits.time;
  EXPECT_TRUE(
      std::isinf(time_without_force(controller_maker(ConstantVelocity(motion * slow)), scene)));
}

class UnevenYieldInSeconds : public ::testing::Test {
 protected:
  static DemonstrationSet by(const char* skill) {
    return simulated_demonstrations(load_scene("bench"), OperatorSkill::parse(skill), 21, 8);
  }
  static std::size_t warnings(const DemonstrationSet& set, const LawFile& law,
                              const std::string& of) {
    const std::vector<std::string> all = fit_warnings(set, law);
    return static_cast<std::size_t>(std::count_if(
        all.begin(), all.end(), [&](const std::string& w) { return w.starts_with(of); }));
  }
};

// At skill 0.8 he yields by 0.9e-3 m/s per newton.
TEST_F(UnevenYieldInSeconds, ByPlaceIsWarnedOfAndTheGuardedLawHasBoth) {
  const DemonstrationSet set = by("0.8,bore_yield=0.3");
  const LawFile insertion = fit_law(set, 1, LawKind::insertion).controller;
  for (const char* name : {"yield_y", "yield_z"})
    EXPECT_EQ(warnings(set, insertion, name + std::string(" is not one number: outside the bore")),
              1U);
  const LawFile guarded = fit_law(set, 1, LawKind::guarded).controller;
  EXPECT_EQ(warnings(set, guarded, ""), 0U);
  for (std::size_t i = 0; i < guarded.gains.size(); ++i) {
    const std::string name = gain_table(LawKind::guarded)[i].name;
    if (!name.ends_with("yield_y") && !name.ends_with("yield_z")) continue;
    const double yield = name.starts_with("bore") ? 0.27e-3 : 0.9e-3;
    const FittedGain& gain = guarded.gains[i];
    EXPECT_LE(gain.low, yield) << name;
    EXPECT_GE(gain.high, yield) << name;
    EXPECT_LT(gain.high - gain.low, 0.5 * yield) << name;
  }
}

TEST_F(UnevenYieldInSeconds, ByForceIsWarnedOf) {
  const DemonstrationSet set = by("0.8,force_yield=0.3");
  const LawFile law = fit_law(set, 1, LawKind::guarded).controller;
  EXPECT_EQ(warnings(set, law, "yield_z is not one number: under small forces"), 1U);
}

}  // namespace
}  // namespace ferrule
