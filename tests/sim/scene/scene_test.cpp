#include "sim/scene/scene.hpp"

#include "sim/scene/draw.hpp"
#include "sim/solver/step.hpp"
#include "tests/compare.hpp"
#include "tests/refusal.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

// What load_scene says of one setting that is wrong.
std::string complaint(const std::string& setting) {
  try {
    load_scene("paper", {setting});
  } catch (const BadInput& error) {
    return error.what();
  }
  return "";
}

TEST(Scene, PaperIsTableI) {
  const World w = testing::paper().world;
  EXPECT_CLOSE(w.annulus.fibre_radius, 62.5e-6, 1e-15);
  EXPECT_CLOSE(w.annulus.clearance(), 0.5e-6, 1e-9);
  EXPECT_CLOSE(w.laws.wall->reduced_modulus, 4.2726925917809e10, 1e-13);
  EXPECT_CLOSE(std::get<printed::VanDerWaals>(w.laws.van_der_waals).hamaker, 3.67e-19, 1e-15);
  EXPECT_CLOSE(std::get<printed::Capillary>(w.laws.capillary).film, 80e-9, 1e-15);
  EXPECT_CLOSE(w.profile.mouth_radius(), 125e-6, 1e-14);
  EXPECT_CLOSE(w.laws.wall->begins, 10e-9, 1e-15);
}

TEST(Scene, AllShippedScenesAreValid) {
  EXPECT_GE(shipped_scenes().size(), 4u);
  for (const auto& name : shipped_scenes()) EXPECT_EQ(load_scene(name).name, name);
}

TEST(Scene, OfARungThatIsNotThereTheOthersAreTold) {
  const std::string why = testing::refusal([] { load_scene("ladder/g"); });
  EXPECT_TRUE(why.starts_with("trouble: ladder/g: ")) << why;
  EXPECT_NE(why.find(" of that name: ladder/a ladder/b ladder/b1 "), std::string::npos) << why;
}

TEST(Scene, DocumentGivesTheSameSceneAgain) {
  const Scene a = testing::paper({"laws.electrostatic.voltage_V=0.25"});
  const Scene b = parse_scene(Json::parse(a.document().dump()), "again");
  EXPECT_EQ(std::get<printed::Electrostatic>(b.world.laws.electrostatic).voltage, 0.25);
  EXPECT_EQ(a.document(), b.document());
}

TEST(Scene, NullRemovesALaw) {
  EXPECT_FALSE(present(testing::paper({"laws.capillary=null"}).world.laws.capillary));
}

TEST(Scene, AdhesionAbsentLetsTheWallBeginAtTouch) {
  EXPECT_EQ(testing::paper({"laws.adhesion=null"}).world.laws.wall->begins, 0);
}

TEST(Scene, ComplaintsNameKeyValueAndRule) {
  EXPECT_NE(complaint("fibre.diameter_um=-3").find("fibre.diameter_um = -3: must be positive"),
            std::string::npos);
  EXPECT_NE(complaint("fibre.young_GPa=nan").find("fibre.young_GPa=nan: must be a number"),
            std::string::npos);
  EXPECT_NE(complaint("laws.capilary={}").find("laws.capilary = {}: unknown key"),
            std::string::npos);
  EXPECT_NE(complaint("ferrule.bore_diameter_um=124").find("must be wider than the fibre"),
            std::string::npos);
  EXPECT_NE(complaint("ferrule.bore_diameter_um=125").find("must be wider than the fibre"),
            std::string::npos);
  EXPECT_NE(complaint("start.tilt_y_mrad=301").find("must be from -300 to 300"), std::string::npos);
  EXPECT_NE(complaint("laws.adhesion.maugis_lambda=9").find("must be from 0.12 to 5.8"),
            std::string::npos);
  EXPECT_NE(complaint("laws.capillary.form=exact").find("must be one of \"printed\" \"corrected\""),
            std::string::npos);
  EXPECT_NE(complaint("start=null").find("start = null: must be an object"), std::string::npos);
  EXPECT_NE(complaint("limits.time_s=\"long\"").find("must be a number"), std::string::npos);
  EXPECT_NE(complaint("nonsense").find("--set nonsense: must be dotted.key=value"),
            std::string::npos);
  for (const auto* wrong : {"fibre.diameter_um=-3", "laws.capilary={}", "start=null"})
    EXPECT_EQ(complaint(wrong).find('\n'), std::string::npos);
}

TEST(Scene, RefusesAFibreThatHangsSteeply) {
  const Json document = load_scene("bench").document();
  Json soft = document;
  soft["fibre"]["young_GPa"] = 1e-3 * document["fibre"]["young_GPa"].get<double>();
  EXPECT_NO_THROW(parse_scene(document, "bench"));
  try {
    soft["holder"]["free_length_mm"] = 30;
    parse_scene(soft, "soft");
    ADD_FAILURE();
  } catch (const BadInput& error) {
    EXPECT_NE(std::string(error.what()).find("soft: holder.free_length_mm = 30: must be so short"),
              std::string::npos)
        << error.what();
  }
}

TEST(Scene, RefusesAVoltageThatNoSurfaceBearsAndNamesTheRoughnessThatDoes) {
  for (const char* roughness : {"roughness_nm=0", "roughness_nm=2.3"}) {
    std::string said;
    try {
      load_scene("bench", {"laws.electrostatic.voltage_V=213.7", roughness});
    } catch (const BadInput& error) {
      said = error.what();
    }
    const std::string before = "or roughness_nm at least ";
    const auto named = said.find(before);
    ASSERT_NE(named, std::string::npos) << said;
    const std::string least =
        said.substr(named + before.size(), said.rfind(':') - named - before.size());
    EXPECT_CLOSE(std::stod(least), 21.37, 1e-12);
    EXPECT_NO_THROW(
        load_scene("bench", {"laws.electrostatic.voltage_V=213.7", "roughness_nm=" + least}));
  }
  EXPECT_NO_THROW(load_scene("bench", {"laws.electrostatic.voltage_V=1", "roughness_nm=0"}));
  EXPECT_NO_THROW(load_scene("paper", {"laws.electrostatic.voltage_V=213.7"}));
}

TEST(Scene, RefusesAKeyThatDoesNothingWithoutAnother) {
  const std::string drift = "sensor.temperature_drift_uN_K=1",
                    rate = "sensor.temperature_rate_K_s=1", offset_y = "joint.offset_y_um=0.2",
                    offset_z = "joint.offset_z_um=0.2";
  for (const auto& [key, others] :
       {std::pair(std::string("fibre.roll_deg=20"),
                  std::vector<std::string>{"fibre.cleave_deg=1", "fibre.curl_radius_m=4"}),
        {"fibre.cleave_direction_deg=20", {"fibre.cleave_deg=1"}},
        {"ferrule.ovality_direction_deg=20", {"ferrule.ovality_um=0.1"}},
        {"sensor.vibration_Hz=20", {"sensor.vibration_uN=1"}},
        {drift, {rate}},
        {rate, {drift}},
        {offset_y, {offset_z}},
        {offset_z, {offset_y}}}) {
    for (const std::string& other : others) EXPECT_NO_THROW(load_scene("bench", {key, other}));
    try {
      load_scene("bench", {key});
      ADD_FAILURE() << key;
    } catch (const BadInput& error) {
      const std::string said = error.what();
      EXPECT_NE(said.find(key.substr(0, key.find('='))), std::string::npos) << said;
      EXPECT_NE(said.find("does nothing without"), std::string::npos) << said;
    }
  }
}

TEST(Scene, AJointIsThatOfStandardFibreUnlessStated) {
  const Scene plain = load_scene("bench");
  EXPECT_EQ(plain.joint.wavelength, 1550e-9);
  EXPECT_EQ(plain.joint.index, 1.4682);
  EXPECT_EQ(plain.joint.mode_radius, 5.2e-6);
  EXPECT_FALSE(plain.joint.partner_mode_radius);
  EXPECT_EQ(plain.joint.gap, 0);
  EXPECT_TRUE(std::isinf(plain.success.loss_dB));
  const Scene stated = load_scene(
      "bench",
      {"joint.wavelength_nm=1310", "joint.index=1.4677", "joint.mode_field_diameter_um=9.2",
       "joint.partner_mode_field_diameter_um=8.6", "joint.gap_um=2",
       "joint.core_concentricity_sd_um=0.2", "joint.bore_concentricity_sd_um=0.4",
       "joint.offset_y_um=0.5", "joint.offset_z_um=-0.1", "success.loss_dB=0.3"});
  EXPECT_CLOSE(stated.joint.wavelength, 1310e-9, 1e-15);
  EXPECT_EQ(stated.joint.index, 1.4677);
  EXPECT_CLOSE(stated.joint.mode_radius, 4.6e-6, 1e-15);
  EXPECT_CLOSE(stated.joint.partner_mode_radius.value(), 4.3e-6, 1e-15);
  EXPECT_CLOSE(stated.joint.gap, 2e-6, 1e-15);
  EXPECT_CLOSE(stated.joint.core_sd, 0.2e-6, 1e-15);
  EXPECT_CLOSE(stated.joint.bore_sd, 0.4e-6, 1e-15);
  EXPECT_CLOSE(stated.joint.offset.x(), 0.5e-6, 1e-15);
  EXPECT_CLOSE(stated.joint.offset.y(), -0.1e-6, 1e-15);
  EXPECT_EQ(stated.success.loss_dB, 0.3);
  for (const char* wrong : {"joint.wavelength_nm=0", "joint.index=0.9", "joint.gap_um=-1",
                            "joint.mode_field_diameter_um=0", "joint.core_concentricity_sd_um=-1",
                            "joint.radius_um=1", "success.loss_dB=0"})
    EXPECT_THROW(load_scene("bench", {wrong}), BadInput) << wrong;
}

TEST(Scene, EveryKeyIsRequiredAndNamed) {
  const Json whole = testing::paper().document();
  const Json flat = whole.flatten();
  int tried = 0;
  for (const auto& [pointer, value] : flat.items()) {
    if (pointer == "/about" || pointer.find("/laws/") == 0) continue;
    Json part = whole;
    const Json::json_pointer p(pointer);
    if (part[p.parent_pointer()].is_array()) continue;
    part[p.parent_pointer()].erase(p.back());
    if (value.is_null() || value.is_object()) continue;
    ++tried;
    try {
      parse_scene(part, "file.json");
      ADD_FAILURE() << pointer << " is not required";
    } catch (const BadInput& error) {
      EXPECT_NE(std::string(error.what()).find(p.back() + " is missing"), std::string::npos)
          << error.what();
    }
  }
  EXPECT_GT(tried, 20);
}

// Drives a start of the scene in and sideways: everything that is computed on the way is finite.
bool computes(const Scene& scene) {
  StepResult r(draw_start(scene, 3, 1));
  const double c = scene.world.annulus.clearance();
  Pose end = Pose::Zero();
  end[0] = -std::min(scene.success.depth, 20e-6);
  end[1] = 2 * c;
  const Pose from = r.state.command, to = end - scene.world.holder.sag;
  for (int n = 1; n <= 12; ++n) {
    step_on(scene.world, from + n / 12.0 * (to - from), 1e-3, r);
    bool finite = to_row(r.state).allFinite() && r.holder.allFinite();
    const Breakdown breakdown = forces(scene.world, r);
    for (const TermForces& term : breakdown.terms)
      for (const PointForce& f : term) finite = finite && f.force.allFinite();
    if (!finite) return false;
  }
  return true;
}

// A start 30 um aside, 20 um before the bore, is 18 um deep in a cone of 60 degrees: an end with
// inertia leans on it, and stays.
TEST(Scene, AnEndWithInertiaIsNotFlungOutOfTheLeadIn) {
  const Scene scene = load_scene(
      "bench", {"dynamics=inertial", "start.distance_um=20", "start.lateral_mean_um=[30,0]",
                "start.lateral_sd_um=0", "start.tilt_sd_mrad=0"});
  const State start = draw_start(scene, 1, 1);
  EXPECT_TRUE(start.contact[kEnd].closed);
  EXPECT_LT(start.contact[kEnd].depth, 1e-6);
  EXPECT_EQ(start.velocity, Pose::Zero());
  StepResult now(start);
  State& state = now.state;
  for (int n = 0; n < 200; ++n) step_on(scene.world, start.command, 1e-5, now);
  EXPECT_LT((state.tip - start.tip).head<3>().norm(), 10e-9);
  EXPECT_LT(state.velocity.head<3>().norm(), 1e-3);
  const State without = draw_start(
      load_scene("bench", {"start.distance_um=20", "start.lateral_mean_um=[30,0]"}), 1, 1);
  EXPECT_NEAR(without.tip[0], 20e-6, 1e-18);
}

TEST(Scene, EveryNumberIsRefusedInOneLineOrCanBeComputedWith) {
  int refused = 0, computed = 0;
  for (const auto& name : shipped_scenes()) {
    const Json whole = load_scene(name).document();
    const Json flat = whole.flatten();
    for (const auto& [pointer, value] : flat.items()) {
      if (!value.is_number()) continue;
      const Json::json_pointer at(pointer);
      for (const double extreme : {1e308, -1e308, 1e-300, 0.0}) {
        Json document = whole;
        document[at] = extreme;
        // A table of adhesion takes milliseconds to make.
        if (pointer.find("/laws/adhesion") != 0) document["laws"].erase("adhesion");
        try {
          EXPECT_TRUE(computes(parse_scene(document, name))) << name << pointer << extreme;
          ++computed;
        } catch (const BadInput& error) {
          const std::string says = error.what();
          EXPECT_EQ(says.find('\n'), std::string::npos) << says;
          // Numbers of a list are named by their list.
          const bool listed = whole[at.parent_pointer()].is_array();
          const std::string key = listed ? at.parent_pointer().back() : at.back();
          EXPECT_NE(says.find(key), std::string::npos) << says;
          EXPECT_NE(says.find("must"), std::string::npos) << says;
          ++refused;
        }
      }
    }
  }
  EXPECT_GT(refused, 1000);
  EXPECT_GT(computed, 100);
}

TEST(Scene, MissingFileIsFileTrouble) {
  EXPECT_THROW(load_scene("no/such/file.json"), FileTrouble);
  EXPECT_THROW(load_scene("nosuchscene"), FileTrouble);
}

TEST(Scene, FormNamesTheLawsThatLackIt) {
  Json document =
      testing::paper({"laws.drag={\"form\": \"corrected\", \"viscosity_Pa_s\": 1}"}).document();
  try {
    set_form(document, Form::printed, "paper");
    FAIL();
  } catch (const BadInput& error) {
    EXPECT_NE(std::string(error.what()).find("drag"), std::string::npos);
    EXPECT_EQ(std::string(error.what()).find("gravity"), std::string::npos);
  }
}

TEST(JsonFields, BrokenJsonNamesFileAndLine) {
  try {
    parse_json("{\n\"a\": 1,\n\"b\": NaN\n}", "x.json");
    FAIL();
  } catch (const BadInput& error) {
    EXPECT_NE(std::string(error.what()).find("x.json: not valid JSON: parse error at line 3"),
              std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace ferrule
