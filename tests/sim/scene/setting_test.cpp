#include "sim/scene/setting.hpp"

#include <gtest/gtest.h>

#include "tests/scenes.hpp"

namespace ferrule {
namespace {

Json with(const std::vector<std::string>& settings) {
  Json document = testing::paper().document();
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

TEST(Setting, ANumberIsDrawnWithinWhatADrawingStates) {
  for (const auto& [text, drawn] : {std::pair("125+-0.75", Json{{"normal", {125, 0.25}}}),
                                    {"125.5+1/-0", Json{{"uniform", {125.5, 126.5}}}},
                                    {"126.25 +0.25 / -0.75", Json{{"uniform", {125.5, 126.5}}}},
                                    {"125.5..127", Json{{"uniform", {125.5, 127}}}}})
    for (const std::string key : {"ferrule.young_GPa", "fibre.young_GPa"}) {
      const Json d = with({key + "=" + text});
      EXPECT_EQ(d.at(pointer_to(key)), drawn) << text;
      EXPECT_EQ(parse_scene(d, text).drawn.front().key, key);
      EXPECT_NO_THROW(parse_scene(with({key + "=" + drawn.dump()}), text));
    }
  EXPECT_EQ(with({"fibre.diameter_um=124..125"})["fibre"]["diameter_um"].dump(),
            R"({"uniform":[124,125]})");
  EXPECT_EQ(with({"name=from..to"})["name"], "from..to");
}

TEST(Setting, WhatIsSetLastHolds) {
  const auto diameters = [](const std::vector<std::string>& settings) {
    const Json d = with(settings);
    EXPECT_NO_THROW(parse_scene(d, "twice"));
    return std::pair(d["fibre"]["diameter_um"], d.value("tolerance", Json()));
  };
  EXPECT_EQ(diameters({"fibre.diameter_um=125+-0.3", "fibre.diameter_um=124.5"}),
            std::pair(Json(124.5), Json()));
  const Json sd = {{"fibre_diameter_sd_um", 0.1}};
  EXPECT_EQ(diameters({"fibre.diameter_um=124..125", "tolerance.fibre_diameter_sd_um=0.1"}),
            std::pair(Json(124.5), sd));
  EXPECT_EQ(diameters({"tolerance.fibre_diameter_sd_um=0.1", "fibre.diameter_um=124"}),
            std::pair(Json(124), Json()));
  EXPECT_EQ(
      diameters({"tolerance.fibre_diameter_sd_um=0.1", "ferrule.bore_diameter_um=127"}).second, sd);
}

TEST(Setting, ANumberSaysWhatItMayBe) {
  for (const char* wrong : {"wide", "125+-", "a+-1", "126+--0.1", "127..126", "..126", "126+1",
                            "126+1/0", "126-1/+0", "126+1/--1", "125...126"})
    EXPECT_EQ(said_of({std::string("ferrule.bore_diameter_um=") + wrong}),
              std::string("--set ferrule.bore_diameter_um=") + wrong +
                  ": must be a number, or drawn as 126+-0.3, 125.5+1/-0 or 125.2..126.5");
}

}  // namespace
}  // namespace ferrule
