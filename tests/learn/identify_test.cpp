#include "learn/identify.hpp"

#include "controller/statistics.hpp"
#include "sim/base/random.hpp"
#include "sim/scene/draw.hpp"
#include "tests/compare.hpp"
#include "tests/episodes.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

constexpr const char* kFriction = "laws.friction.burgers_nm";
constexpr const char* kAdhesion = "laws.adhesion.work_of_adhesion_J_m2";
constexpr const char* kBore = "ferrule.bore_diameter_um";

Scene scene_with(std::vector<std::string> settings) {
  for (const char* quick : {"start.distance_um=6", "success.depth_um=6", "limits.speed_um_s=20"})
    settings.emplace_back(quick);
  return testing::paper(settings);
}

// Without the printed wells: whether a recording falls into one, and when, is no smooth function of
// the parameters.
Scene without_wells(std::vector<std::string> settings) {
  for (const char* none :
       {"laws.van_der_waals=null", "laws.electrostatic=null", "laws.capillary=null"})
    settings.emplace_back(none);
  return scene_with(std::move(settings));
}

// Simulated operators in `scene`; every force at the holder carries noise [N] of a sensor.
std::vector<Recording> recordings(const Scene& scene, double noise, std::uint64_t seed,
                                  std::uint64_t episodes = 4) {
  std::vector<Recording> all;
  for (std::uint64_t trial = 1; trial <= episodes; ++trial) {
    const State start = draw_start(scene, seed, trial);
    const auto device = simulated_operator(testing::setup(scene, trial, seed), 0.8);
    const Episode episode{testing::info_of(scene, seed, trial),
                          testing::record_rows(scene, start, *device).matrix(),
                          {}};
    all.push_back(recording(episode, "episode " + std::to_string(trial)));
    RandomStream random(seed, trial, Draw::split);
    for (Eigen::Index n = 0; n < all.back().wrench.rows(); ++n)
      for (int axis = 0; axis < 3; ++axis) all.back().wrench(n, axis) += noise * random.normal();
  }
  return all;
}

TEST(Identify, ReplaysARecordingInItsOwnSceneExactly) {
  const Scene scene = scene_with({});
  const Identification i = identify(recordings(scene, 0, 1), scene, {"ferrule.length_mm"}, 1);
  EXPECT_LT(i.residual_start, 1e-15);
  EXPECT_GT(i.rows, 300u);
}

// Where an event comes a moment earlier or later the fit is not smooth: now and then it ends beside
// them.
TEST(IdentifyAtLength, FindsTheParametersOfRecordingsWithoutNoise) {
  constexpr int kSets = 12;
  std::vector<double> of_friction, of_adhesion, residuals;
  for (std::uint64_t seed = 0; seed < kSets; ++seed) {
    const auto data = recordings(
        without_wells({"laws.friction.burgers_nm=0.6", "laws.adhesion.work_of_adhesion_J_m2=0.2"}),
        0, seed);
    const Identification i = identify(data, without_wells({}), {kFriction, kAdhesion}, 1);
    of_friction.push_back(std::abs(i.parameters[0].value / 0.6 - 1));
    of_adhesion.push_back(std::abs(i.parameters[1].value / 0.2 - 1));
    residuals.push_back(i.residual / i.residual_start);
  }
  EXPECT_LT(quantile(of_friction, 0.5), 1e-5);
  EXPECT_LT(quantile(of_adhesion, 0.5), 1e-3);
  for (const auto& all : {of_friction, of_adhesion}) EXPECT_LT(quantile(all, 1), 3e-2);
  EXPECT_LT(quantile(residuals, 0.9), 0.01);
}

// From another scene, for pairs of parameters and several seeds, with a sensor's noise of 20 nN.
TEST(IdentifyAtLength, IntervalsHoldTheParametersOfNoisyRecordings) {
  int inside = 0, all = 0;
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    const auto data = recordings(without_wells({}), 2e-8, seed, 8);
    for (const auto& [start, keys] : {std::pair{without_wells({"laws.friction.burgers_nm=0.8",
                                                               "ferrule.bore_diameter_um=126.4"}),
                                                std::vector<std::string>{kFriction, kBore}},
                                      {without_wells({"laws.friction.burgers_nm=0.3",
                                                      "laws.adhesion.work_of_adhesion_J_m2=0.3"}),
                                       {kFriction, kAdhesion}}}) {
      for (const IdentifiedParameter& p : identify(data, start, keys, seed).parameters) {
        const double truth = p.key == kFriction ? 0.48 : p.key == kBore ? 126 : 0.144;
        ASSERT_EQ(p.told, Told::fitted) << p.key;
        EXPECT_LE(std::abs(p.value - truth), 2 * (p.high - p.low)) << p.key << " " << p.value;
        // The clearance is 1 um.
        EXPECT_LT(p.high - p.low, p.key == kBore ? 0.1 : 4 * truth) << p.key;
        inside += p.low <= truth && truth <= p.high;
        ++all;
      }
    }
  }
  EXPECT_GE(inside, all - 2) << "of " << all;
}

TEST(Identify, WhatTheRecordingsTellNothingAboutIsOpen) {
  const auto data = recordings(scene_with({}), 1e-8, 1);
  const Identification i = identify(data, scene_with({"laws.friction.burgers_nm=0.7"}),
                                    {"ferrule.length_mm", kFriction, "limits.time_s"}, 1);
  for (const std::size_t k : {0u, 2u}) {
    EXPECT_EQ(i.parameters[k].told, Told::open);
    for (const double x : {i.parameters[k].value, i.parameters[k].low, i.parameters[k].high})
      EXPECT_TRUE(std::isnan(x));
  }
  EXPECT_EQ(i.parameters[1].told, Told::fitted);
  EXPECT_LE(i.parameters[1].low, 0.48);
  EXPECT_GE(i.parameters[1].high, 0.48);
}

// A meniscus pulls with its tension times the cosine of the contact angle: either can stand for the
// other.
TEST(Identify, ParametersThatStandForEachOtherAreOpen) {
  const auto liquid = [](double tension) {
    const Json law = {
        {"form", "corrected"}, {"surface_tension_N_m", tension}, {"contact_angle_deg", 40}};
    return scene_with({"laws.meniscus=" + law.dump()});
  };
  const auto data = recordings(liquid(0.01), 1e-8, 1);
  const Identification i =
      identify(data, liquid(0.012),
               {"laws.meniscus.surface_tension_N_m", "laws.meniscus.contact_angle_deg"}, 1);
  EXPECT_EQ(i.parameters[0].told, Told::open);
  EXPECT_EQ(i.parameters[1].told, Told::open);
}

// The clearance tells much of the difference of two diameters, and little of either.
TEST(Identify, ParametersThatAlmostStandForEachOtherAreOpen) {
  const auto data = recordings(scene_with({}), 1e-8, 1);
  const Identification i = identify(data, scene_with({"ferrule.bore_diameter_um=126.2"}),
                                    {"fibre.diameter_um", kBore}, 1);
  EXPECT_GT(std::abs(i.correlation(0, 1)), 0.99);
  EXPECT_EQ(i.parameters[0].told, Told::open);
  EXPECT_EQ(i.parameters[1].told, Told::open);
}

TEST(Identify, AParameterBeyondItsBoundIsSaidToBeThere) {
  const auto data = recordings(scene_with({}), 1e-8, 1);
  const IdentifiedParameter p =
      identify(data, scene_with({"laws.friction.burgers_nm=0.02"}), {kFriction}, 1).parameters[0];
  EXPECT_EQ(p.told, Told::at_bound);
  EXPECT_CLOSE(p.highest, 0.2, 1e-9);
  EXPECT_TRUE(std::isnan(p.high));
}

// Forces of a scene, with the noise that its sensor is said to have.
Scene with_sensor(std::vector<std::string> settings) {
  settings.insert(settings.begin(), "sensor.noise_uN=0.02");
  return without_wells(std::move(settings));
}

TEST(Identify, AModelThatHasItAllFits) {
  for (const std::uint64_t seed : {1, 2}) {
    const auto data = recordings(with_sensor({}), 2e-8, seed);
    const Identification i =
        identify(data, with_sensor({"ferrule.bore_diameter_um=126.2"}), {kBore}, seed);
    EXPECT_TRUE(i.fits()) << i.misfit;
    EXPECT_CLOSE(i.misfit, 0.71, 0.15);  // 20 nN of noise, and 20 nN to which the fit is good
    EXPECT_CLOSE(i.noise, std::sqrt(6.0) * 2e-8, 0.01);
  }
}

// Neither noise nor a sensor that is said to have some; and a sensor with a bias.
TEST(Identify, AModelThatHasItAllFitsWhateverTheSensor) {
  for (const auto& [noise, sensor] :
       {std::pair{0.0, "sensor={}"}, {5e-8, "sensor={}"}, {0.0, "sensor.bias_uN=0.1"}}) {
    const Scene start = without_wells({"ferrule.bore_diameter_um=126.2", sensor});
    auto data = recordings(without_wells({}), noise, 3);
    if (start.sensor.biased())
      for (std::size_t k = 0; k < data.size(); ++k)
        data[k].wrench.col(1).array() += k % 2 == 0 ? 1e-7 : -1e-7;
    const Identification i = identify(data, start, {kBore}, 1);
    EXPECT_TRUE(i.fits()) << sensor << " " << noise << ": " << i.misfit;
  }
}

// As the scene's sensor reads them.
std::vector<Recording> sensed(const Scene& scene, std::uint64_t seed) {
  std::vector<Recording> all = recordings(scene, 0, seed);
  for (std::uint64_t trial = 1; trial <= all.size(); ++trial) {
    ForceSensor sensor(scene.sensor, seed + 100, trial);
    Recording& one = all[trial - 1];
    for (Eigen::Index n = 0; n < one.wrench.rows(); ++n)
      one.wrench.row(n) = sensor.read(one.wrench.row(n).transpose(), one.period).transpose();
  }
  return all;
}

// Nothing is fitted here: what is left is noise. Errors that last are fewer independent ones.
TEST(Identify, NoiseAloneStaysBelowItsLimit) {
  const auto held = [](const char* sensor, std::uint64_t seed) {
    const Scene scene = with_sensor({"sensor.noise_uN=0.05", sensor});
    return identify(sensed(scene, seed), scene, {"ferrule.length_mm"}, seed);
  };
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Identification white = held("sensor.resolution_uN=0.01", seed);
    EXPECT_LT(white.misfit, white.misfit_limit) << seed;
    EXPECT_GT(white.misfit, 0.8) << seed;
    const double freedom = 3 * static_cast<double>(white.rows);
    EXPECT_CLOSE(white.misfit_limit, 1 + 3.09 / std::sqrt(2 * freedom), 3e-3);
    for (const char* lasting : {"sensor.bias_walk_uN_sqrt_s=0.05", "sensor.gain_error=0.1"}) {
      const Identification i = held(lasting, seed);
      EXPECT_LT(i.misfit, i.misfit_limit) << lasting << " " << seed;
      EXPECT_GT(i.misfit_limit, 1.05) << lasting << " " << seed;
    }
  }
}

// By less than half of the noise.
TEST(Identify, ANumberThatIsHeldAtAWrongValueIsFound) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const auto data = sensed(with_sensor({"sensor.noise_uN=0.05"}), seed);
    const Identification i =
        identify(data, with_sensor({"sensor.noise_uN=0.05", "laws.friction.burgers_nm=1.3"}),
                 {"ferrule.length_mm"}, seed);
    EXPECT_FALSE(i.fits()) << seed << ": " << i.misfit << ", " << i.misfit_limit;
    EXPECT_LT(i.misfit, 1.5) << seed;
  }
}

// What is recorded has more than the model knows.
TEST(Identify, AModelThatLacksSomethingIsSaidNotToFit) {
  for (const char* more : {"fibre.edge_um=4", "fibre.cleave_deg=3"}) {
    const auto data = recordings(with_sensor({more}), 2e-8, 1);
    const Identification i =
        identify(data, with_sensor({"ferrule.bore_diameter_um=126.2"}), {kBore}, 1);
    EXPECT_FALSE(i.fits()) << more << ": " << i.misfit << ", " << i.residual;
    EXPECT_GT(i.residual, 1.5 * std::sqrt(3.0) * 2e-8) << more;
  }
}

TEST(Identify, RefusesWhatItCannotVary) {
  const Scene scene = scene_with({"quadrature=3"});
  const auto data = recordings(scene, 0, 1);
  const auto complaint = [&](const std::vector<Recording>& some, std::vector<std::string> keys) {
    try {
      identify(some, scene, keys, 1);
    } catch (const BadInput& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(complaint({data[0], data[1]}, {kFriction}).find("too few episodes"), std::string::npos);
  EXPECT_NE(complaint(data, {"laws.friction.b"}).find("laws.friction.b: there is no such number"),
            std::string::npos);
  EXPECT_NE(complaint(data, {"laws.friction"}).find("no such number"), std::string::npos);
  EXPECT_NE(complaint(data, {"laws..friction"}).find("no such number"), std::string::npos);
  EXPECT_NE(complaint(data, {"laws~"}).find("no such number"), std::string::npos);
  EXPECT_NE(complaint(data, {kFriction, kFriction}).find("is there twice"), std::string::npos);
  EXPECT_NE(complaint(data, {"quadrature"}).find("cannot be varied"), std::string::npos);
}

}  // namespace
}  // namespace ferrule
