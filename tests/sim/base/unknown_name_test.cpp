#include "sim/base/unknown_name.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace ferrule {
namespace {

const std::vector<std::string> kVerbs = {"demo", "evaluate", "fit", "forces", "bench"};

TEST(UnknownName, TheNearestIsThatWithTheFewestSlips) {
  EXPECT_EQ(nearest("evalute", kVerbs), "evaluate");
  EXPECT_EQ(nearest("froces", kVerbs), "forces");
  EXPECT_EQ(nearest("--trails", {"--trials-out", "--trials"}), "--trials");
  EXPECT_EQ(nearest("eval", kVerbs), "evaluate");  // begins it
}

TEST(UnknownName, NothingIsNearAnotherWord) {
  EXPECT_EQ(nearest("dance", kVerbs), "");
  EXPECT_EQ(nearest("", kVerbs), "");
  EXPECT_EQ(nearest(std::string(100000, 'e'), kVerbs), "");
  EXPECT_EQ(nearest("demo", {}), "");
  EXPECT_EQ(did_you_mean("dance", kVerbs), "");
  EXPECT_EQ(did_you_mean("dmo", kVerbs), ": did you mean demo?");
}

TEST(UnknownName, AnotherUnitIsConverted) {
  const auto said = [](const char* key, const nlohmann::json& value, const char* meant) {
    return unknown_key(key, value, meant);
  };
  EXPECT_EQ(said("ferrule.bore_mm", 0.1255, "ferrule.bore_um"),
            "unknown key; here it is ferrule.bore_um = 125.5");
  EXPECT_EQ(said("bore_mm", 0.1255, "ferrule.bore_um"),
            "unknown key; here it is ferrule.bore_um = 125.5");
  EXPECT_EQ(said("surface_tension_mN_m", 45, "surface_tension_N_m"),
            "unknown key; here it is surface_tension_N_m = 0.045");
  EXPECT_EQ(said("tilt_deg", 180, "tilt_mrad"),
            "unknown key; here it is tilt_mrad = 3141.59265359");
}

TEST(UnknownName, NoNumberIsMadeUp) {
  for (const auto& [key, value, meant] :
       {std::tuple("bore_mm", nlohmann::json("wide"), "bore_um"),
        {"bore_inch", 1, "bore_um"},
        {"bor_mm", 1, "bore_um"},                // differs in more than the unit
        {"bore_mN", 1, "bore_um"},               // of another dimension
        {"stiffness_N_mm", 1, "stiffness_N_m"},  // N/mm or N mm
        {"bore", 1, "bore_um"}})
    EXPECT_EQ(unknown_key(key, value, meant),
              std::string("unknown key; did you mean ") + meant + "?");
}

}  // namespace
}  // namespace ferrule
