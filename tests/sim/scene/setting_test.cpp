#include "sim/scene/setting.hpp"

#include <gtest/gtest.h>

#include "tests/scenes.hpp"

namespace ferrule {
namespace {

Json with(const std::vector<std::string>& settings) {
  Json document = testing::paper().document;
  for (const std::string& setting : settings) apply_setting(document, setting);
  return document;
}

std::string said_of(const std::vector<std::string>& settings) {
  try {
    with(settings);
  } catch (const BadInput& error) {
    return error.what();
  }
  return "";
}

TEST(Setting, ABoreIsWithinItsTolerance) {
  for (const auto& [text, low, middle, high] : {std::tuple("126+-0.5", 125.5, 126.0, 126.5),
                                                {"125.5+1/-0", 125.5, 126.0, 126.5},
                                                {"126.25 +0.25 / -0.75", 125.5, 126.0, 126.5},
                                                {"125.5..126.5", 125.5, 126.0, 126.5}}) {
    const Json d = with({std::string("ferrule.bore_diameter_um=") + text});
    EXPECT_EQ(d["ferrule"]["bore_diameter_um"], middle) << text;
    EXPECT_EQ(d["ferrule"]["bore_diameter_um"].dump(), "126") << text;
    EXPECT_EQ(d["tolerance"]["bore_diameter_um"], (Json{low, high})) << text;
    EXPECT_EQ(d["tolerance"]["fibre_diameter_sd_um"], 0) << text;
    EXPECT_NO_THROW(parse_scene(d, text));
  }
}

TEST(Setting, AFibreIsNormalAboutANumberAndUniformBetweenTwo) {
  const Json normal = with({"fibre.diameter_um=125+-0.75"});
  EXPECT_EQ(normal["fibre"]["diameter_um"], 125);
  EXPECT_EQ(normal["tolerance"]["fibre_diameter_sd_um"], 0.25);
  EXPECT_FALSE(normal["tolerance"].contains("fibre_diameter_um"));
  const Json width = normal["ferrule"]["bore_diameter_um"];
  EXPECT_EQ(normal["tolerance"]["bore_diameter_um"], (Json{width, width}));
  for (const char* text : {"124.5..125", "125+0/-0.5"}) {
    const Json d = with({std::string("fibre.diameter_um=") + text});
    EXPECT_EQ(d["fibre"]["diameter_um"], 124.75) << text;
    EXPECT_EQ(d["tolerance"]["fibre_diameter_um"], (Json{124.5, 125.0})) << text;
    EXPECT_FALSE(d["tolerance"].contains("fibre_diameter_sd_um")) << text;
    EXPECT_NO_THROW(parse_scene(d, text));
  }
}

TEST(Setting, TheLastToleranceOfAPartHolds) {
  const Json d = with({"ferrule.bore_diameter_um=126..127", "fibre.diameter_um=125+-0.3",
                       "fibre.diameter_um=124..125", "ferrule.bore_diameter_um=126+-0.25"});
  EXPECT_EQ(d["tolerance"],
            (Json{{"fibre_diameter_um", {124.0, 125.0}}, {"bore_diameter_um", {125.75, 126.25}}}));
  EXPECT_NO_THROW(parse_scene(d, "twice"));
}

TEST(Setting, ADiameterSaysWhatItMayBe) {
  for (const char* wrong : {"wide", "125+-", "a+-1", "126+--0.1", "127..126", "..126", "126+1",
                            "126+1/0", "126-1/+0", "126+1/--1", "125...126"})
    EXPECT_EQ(said_of({std::string("ferrule.bore_diameter_um=") + wrong}),
              std::string("--set ferrule.bore_diameter_um=") + wrong +
                  ": must be a number, or a tolerance as 126+-0.3, 125.5+1/-0 or 125.2..126.5");
}

TEST(Setting, NothingElseHasATolerance) {
  for (const char* text : {"72+-1", "72+1/-0", "70..72"})
    EXPECT_EQ(said_of({std::string("fibre.young_GPa=") + text}),
              std::string("--set fibre.young_GPa=") + text +
                  ": only fibre.diameter_um and ferrule.bore_diameter_um take a tolerance");
  EXPECT_EQ(said_of({"name=from..to"}), "");
}

TEST(Setting, ANumberBesideATolerance) {
  EXPECT_NE(said_of({"fibre.diameter_um=124..125", "fibre.diameter_um=125"})
                .find("the scene draws it from tolerance.fibre_diameter_um"),
            std::string::npos);
  EXPECT_NE(said_of({"fibre.diameter_um=125+-0.3", "ferrule.bore_diameter_um=127"})
                .find("the scene draws it from tolerance.bore_diameter_um"),
            std::string::npos);
  // The mean of what is normal.
  EXPECT_EQ(said_of({"fibre.diameter_um=125+-0.3", "fibre.diameter_um=124"}), "");
  EXPECT_EQ(said_of({"fibre.diameter_um=124..125", "tolerance=null", "fibre.diameter_um=125"}), "");
}

}  // namespace
}  // namespace ferrule
