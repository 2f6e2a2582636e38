#include "bench/sensors.hpp"

#include <fmt/format.h>

#include <array>

#include "controller/campaign.hpp"
#include "insertion/scene_scaling.hpp"
#include "learn/fit_law.hpp"
#include "learn/record_again.hpp"

namespace ferrule {
namespace {

constexpr std::size_t kDemonstrations = 20;
constexpr double kSensorSkill = 0.8;

// Errors as parts of the force limit; a law that reads them tares and leaves out what it is told.
struct TriedSensor {
  const char* name;
  double noise, bias, dead_band;
  bool tares;
};
constexpr std::array kTriedSensors = {
    TriedSensor{"as shipped", 0, 0, 0, false},
    TriedSensor{"noise 1/3", 1.0 / 3, 0, 0, false},
    TriedSensor{"noise 2/3", 2.0 / 3, 0, 0, false},
    TriedSensor{"bias 1/6", 0, 1.0 / 6, 0, false},
    TriedSensor{"bias 1/3", 0, 1.0 / 3, 0, false},
    TriedSensor{"bias 1/3, tare", 0, 1.0 / 3, 0, true},
    TriedSensor{"noise 2/3, tare, dead band 1/3", 2.0 / 3, 0, 1.0 / 3, true},
};
constexpr double kTareTime = 0.2;  // [s]

// A shipped scene with such a sensor.
Scene with(const std::string& scene, const TriedSensor& tried, double limit) {
  std::vector<std::string> settings;
  const auto set = [&](const char* key, double value) {
    if (value > 0) settings.push_back(fmt::format("sensor.{}={}", key, value));
  };
  set("noise_uN", 1e6 * tried.noise * limit);
  set("bias_uN", 1e6 * tried.bias * limit);
  set("tare_s", tried.tares ? kTareTime : 0);
  set("dead_band_uN", 1e6 * tried.dead_band * limit);
  return load_scene(scene, settings);
}

SensorRow tried(const Scene& scene, const std::string& sensor, const MakeController& make,
                std::uint64_t seed, std::size_t trials) {
  const CampaignSummary s = summarise(run_campaign(scene, make, seed, trials, 0, {}));
  return {scene.name, sensor, s.feasible, s.successes};
}

// Those of one scene.
void add_scene(std::vector<SensorRow>& rows, const std::string& name, std::uint64_t seed,
               std::size_t trials) {
  const Scene scene = load_scene(name);
  const LawFit fit =
      fit_law(simulated_demonstrations(scene, kSensorSkill, seed, kDemonstrations), seed);
  for (const TriedSensor& sensor : kTriedSensors)
    rows.push_back(tried(with(name, sensor, scene.limits.force), sensor.name,
                         fit.controller.maker(), seed, trials));
  const double speed = scene_scaling(scene).motion * scene.limits.speed;
  rows.push_back(tried(scene, "none", controller_maker(ConstantVelocity(speed)), seed, trials));
}

}  // namespace

std::vector<SensorRow> bench_sensors(std::uint64_t seed, std::size_t trials,
                                     const std::vector<std::string>& scenes, const GoOn& go_on) {
  Cases<SensorRow> cases;
  for (const std::string& name : scenes)
    cases.push_back([=](std::vector<SensorRow>& rows) { add_scene(rows, name, seed, trials); });
  return rows_of(cases, go_on);
}

}  // namespace ferrule
