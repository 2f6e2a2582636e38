#include "controller/graded_joint.hpp"

#include <algorithm>

#include "controller/campaign.hpp"
#include "sim/scene/draw.hpp"
#include "tests/compare.hpp"
#include "tests/refusal.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

const std::vector<std::string> kStatedConcentricity = {"joint.core_concentricity_sd_um=0.2",
                                                       "joint.bore_concentricity_sd_um=0.3"};

// Perfect cores and bores, and one wavelength, are never assumed without being stated.
TEST(GradedJoint, IsThatOfUsualPartsWhereTheSceneStatesNone) {
  for (const std::string& name : shipped_scenes()) {
    const GradedJoint joint = graded_joint(load_scene(name));
    ASSERT_EQ(joint.at.size(), 2u) << name;
    EXPECT_CLOSE(joint.at[0].wavelength, 1310e-9, 1e-12);
    EXPECT_CLOSE(joint.at[0].mode_radius, 4.6e-6, 1e-12);
    EXPECT_CLOSE(joint.at[1].wavelength, 1550e-9, 1e-12);
    EXPECT_CLOSE(joint.at[1].mode_radius, 5.2e-6, 1e-12);
    EXPECT_EQ(joint.core_sd, 0.2e-6) << name;
    EXPECT_EQ(joint.bore_sd, 0.3e-6) << name;
    EXPECT_EQ(joint.assumed.size(), 6u) << name;
    EXPECT_NE(to_text(joint).find("all assumed"), std::string::npos);
  }
}

TEST(GradedJoint, OfASceneThatStatesItIsThat) {
  const GradedJoint joint = graded_joint(testing::bare(
      {"joint.wavelength_nm=1625", "joint.mode_field_diameter_um=10.8", "joint.index=1.45",
       "joint.gap_um=2", "joint.core_concentricity_sd_um=0", "joint.bore_concentricity_sd_um=0",
       "joint.partner_mode_field_diameter_um=9"}));
  ASSERT_EQ(joint.at.size(), 1u);
  EXPECT_CLOSE(joint.at[0].wavelength, 1625e-9, 1e-12);
  EXPECT_CLOSE(joint.at[0].mode_radius, 5.4e-6, 1e-12);
  EXPECT_CLOSE(*joint.at[0].partner_mode_radius, 4.5e-6, 1e-12);
  EXPECT_CLOSE(joint.at[0].gap, 2e-6, 1e-12);
  EXPECT_EQ(joint.unstated_offset(7, 3), Vector2d(0, 0));
  EXPECT_TRUE(joint.assumed.empty());
  const std::string text = to_text(joint);
  for (const char* part :
       {"1625 nm", "10.8 um", "perfect cores", "gap of 2 um", "all as the scene"})
    EXPECT_NE(text.find(part), std::string::npos) << text;
  // An offset that is stated, or drawn otherwise, is all of it.
  EXPECT_EQ(graded_joint(testing::bare({"joint.offset_y_um=0.1..0.2", "joint.offset_z_um=0"}))
                .unstated_offset(7, 3),
            Vector2d(0, 0));
}

TEST(GradedJoint, HoldsForAllWavelengthsThatAreStated) {
  const GradedJoint joint = graded_joint(testing::bare({"joint.wavelength_nm=[1310,1490,1625]"}));
  ASSERT_EQ(joint.at.size(), 3u);
  EXPECT_CLOSE(joint.at[1].mode_radius, 5.05e-6, 1e-12);  // on the line through 9.2 and 10.4
  const GradedJoint stated = graded_joint(
      testing::bare({"joint.wavelength_nm=[1550,1310]", "joint.mode_field_diameter_um=[10,9]"}));
  EXPECT_CLOSE(stated.at[1].mode_radius, 4.5e-6, 1e-12);
  // The loss with an ideal partner is at the first.
  const Joint first =
      testing::bare({"joint.wavelength_nm=[1625,1310]", "joint.mode_field_diameter_um=[11,9]"})
          .joint;
  EXPECT_CLOSE(first.wavelength, 1625e-9, 1e-12);
  EXPECT_CLOSE(first.mode_radius, 5.5e-6, 1e-12);
}

TEST(GradedJoint, ListsThatDoNotFitAreRefused) {
  for (const char* wrong : {"joint.wavelength_nm=[]", "joint.wavelength_nm=[1310,-1]",
                            "joint.wavelength_nm=[1310,\"a\"]", "joint.wavelength_nm=[[1310]]",
                            "joint.mode_field_diameter_um=[9.2,10.4]", "joint.index=[1.4,1.5]"})
    EXPECT_NE(testing::refusal([&] { testing::bare({wrong}); }).find("joint."), std::string::npos)
        << wrong;
  EXPECT_NE(testing::refusal([] {
              testing::bare(
                  {"joint.wavelength_nm=[1310,1550]", "joint.mode_field_diameter_um=[9,10,11]"});
            }).find("as many as wavelength_nm has: 2"),
            std::string::npos);
}

// To the last bit.
TEST(GradedJoint, WhatIsAssumedIsDrawnAsIfItWereStated) {
  const Scene silent = testing::bare(), stated = testing::bare(kStatedConcentricity);
  const GradedJoint joint = graded_joint(silent);
  std::vector<TrialResult> at_centre, drawn;
  for (std::uint64_t trial = 0; trial < 50; ++trial) {
    TrialResult result{};
    result.outcome = trial % 7 ? Outcome::inserted : Outcome::timeout;
    at_centre.push_back(result);
    result.light.offset = draw_scene(stated, 7, trial)->joint.offset;
    EXPECT_EQ(joint.unstated_offset(7, trial), result.light.offset);
    drawn.push_back(result);
  }
  const Mated one = mated(silent, at_centre, 7), other = mated(stated, drawn, 7);
  EXPECT_EQ(one.untuned.mean_dB, other.untuned.mean_dB);
  EXPECT_EQ(one.tuned.p97_dB, other.tuned.p97_dB);
  EXPECT_GT(one.untuned.mean_dB, 0.05);
  // The worst of both wavelengths is that of the smaller mode field.
  EXPECT_EQ(one.untuned.mean_dB, one.untuned_at[0].mean_dB);
  EXPECT_GT(one.untuned_at[0].mean_dB, 1.2 * one.untuned_at[1].mean_dB);
}

// A core that the scene draws is joined by the bore, which it does not know of.
TEST(GradedJoint, AddsWhatIsNotStatedToWhatIs) {
  const Scene scene = testing::bare({"joint.core_concentricity_sd_um=0.4"});
  const GradedJoint joint = graded_joint(scene);
  EXPECT_EQ(joint.core_sd, 0.4e-6);
  EXPECT_EQ(joint.unstated_sd, 0.3e-6);
  double product = 0, square = 0, count = 4000;
  for (std::uint64_t trial = 0; trial < static_cast<std::uint64_t>(count); ++trial) {
    const double core = 1e6 * draw_scene(scene, 7, trial)->joint.offset.x(),
                 bore = 1e6 * joint.unstated_offset(7, trial).x();
    product += core * bore / count;
    square += bore * bore / count;
  }
  EXPECT_CLOSE(std::sqrt(square), 0.3, 0.04);  // cut at three of them
  EXPECT_LT(std::abs(product) / (0.4 * 0.3), 0.05);
}

}  // namespace
}  // namespace ferrule
