#include "sim/scene/force_sensor.hpp"

#include <algorithm>
#include <vector>

#include "sim/scene/draw.hpp"
#include "tests/compare.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

const Wrench kForce = (Wrench() << 1e-6, -2e-6, 3e-7, 4e-8, -5e-9).finished();

TEST(ForceSensor, AnIdealOneReadsBitForBit) {
  ForceSensor sensor;
  EXPECT_EQ(sensor.read(kForce, 1e-3), kForce);
  EXPECT_EQ(sensor.read(3 * kForce, 1e-3), 3 * kForce);
}

// The answer of a first-order low pass to a step: 1 - exp(-2 pi f t), whatever the sampling.
TEST(ForceSensor, AnswersAStepAsItsBandwidthSays) {
  for (const double bandwidth : {3.0, 40.0, 400.0})
    for (const double period : {1e-3, 2e-4}) {
      ForceSensor sensor({.bandwidth = bandwidth}, 1, 1);
      sensor.read(Wrench::Zero(), period);
      Wrench reading = Wrench::Zero();
      for (int n = 1; n <= 20; ++n) {
        reading = sensor.read(kForce, period);
        const double expected = -std::expm1(-2 * std::numbers::pi * bandwidth * period * n);
        for (int i = 0; i < 5; ++i) EXPECT_CLOSE(reading[i], expected * kForce[i], 1e-12);
      }
    }
}

TEST(ForceSensor, NoiseAndBiasHaveTheirStandardDeviations) {
  const double noise = 2e-7, bias = 5e-7, arm = 0.02;
  const int trials = 400, readings = 200;
  Wrench within = Wrench::Zero(), between = Wrench::Zero();
  for (int trial = 0; trial < trials; ++trial) {
    ForceSensor sensor({.noise = noise, .bias = bias, .arm = arm}, 3,
                       static_cast<std::uint64_t>(trial));
    EXPECT_EQ(sensor.read(kForce, 1e-3), Wrench(kForce));  // just tared
    Wrench sum = Wrench::Zero(), squares = Wrench::Zero();
    for (int n = 0; n < readings; ++n) {
      const Wrench error = sensor.read(kForce, 1e-3) - kForce;
      sum += error;
      squares += error.cwiseAbs2();
    }
    const Wrench mean = sum / readings;
    within += (squares / readings - mean.cwiseAbs2()) / trials;
    between += mean.cwiseAbs2() / trials;
  }
  for (int i = 0; i < 5; ++i) {
    const double unit = i < 3 ? 1 : arm;
    // Five standard errors of a variance: 5 sqrt(2/n).
    EXPECT_CLOSE(within[i] / (unit * unit), noise * noise,
                 5 * std::sqrt(2.0 / (trials * readings)) + 0.01);
    EXPECT_CLOSE(between[i] / (unit * unit), bias * bias + noise * noise / readings,
                 5 * std::sqrt(2.0 / trials));
  }
}

TEST(ForceSensor, ReadsMultiplesOfItsResolution) {
  const double resolution = 3e-8, arm = 0.005;
  ForceSensor sensor({.noise = 1e-7, .resolution = resolution, .arm = arm}, 1, 2);
  for (int n = 0; n < 100; ++n) {
    const Wrench reading = sensor.read(kForce, 1e-3);
    for (int i = 0; i < 5; ++i) {
      const double steps = reading[i] / (i < 3 ? resolution : arm * resolution);
      EXPECT_LE(std::abs(steps - std::round(steps)), 1e-9);
    }
  }
}

// Mean squares over many trials of each component's error after `time`.
Wrench error_after(const ForceSensorModel& model, double time, const Wrench& force) {
  const int trials = 2000, steps = 50;
  Wrench squares = Wrench::Zero();
  for (int trial = 0; trial < trials; ++trial) {
    ForceSensor sensor(model, 5, static_cast<std::uint64_t>(trial));
    sensor.read(Wrench::Zero(), time / steps);
    Wrench reading = Wrench::Zero();
    for (int n = 0; n < steps; ++n) reading = sensor.read(force, time / steps);
    squares += (reading - force).cwiseAbs2() / trials;
  }
  squares.tail<2>() /= model.arm * model.arm;
  return squares;
}
constexpr double kFiveErrors = 0.16;  // 5 sqrt(2/2000), of a variance

TEST(ForceSensor, ABiasThatWalksSpreadsWithTheRootOfTime) {
  for (const double time : {0.5, 20.0}) {
    const Wrench squares = error_after({.bias_walk = 2e-7}, time, kForce);
    for (const double s : squares) EXPECT_CLOSE(s, 4e-14 * time, kFiveErrors);
  }
}

TEST(ForceSensor, GainsAndCrossTalkAreInProportionToTheForce) {
  const Wrench forces = kForce.cwiseQuotient((Wrench() << 1, 1, 1, 0.01, 0.01).finished());
  const Wrench gain = error_after({.gain_error = 0.02}, 1, kForce);
  const Wrench cross = error_after({.cross_talk = 0.01}, 1, kForce);
  for (int i = 0; i < 5; ++i) {
    EXPECT_CLOSE(gain[i], std::pow(0.02 * forces[i], 2), kFiveErrors);
    EXPECT_CLOSE(cross[i], 1e-4 * (forces.squaredNorm() - forces[i] * forces[i]), kFiveErrors);
  }
  EXPECT_EQ(error_after({.gain_error = 0.02, .cross_talk = 0.01}, 1, Wrench::Zero()),
            Wrench(Wrench::Zero()));
}

// k theta t, a product of two normal numbers: its variance is that of their product. Its fourth
// moment is 9 times that squared.
TEST(ForceSensor, DriftsWithTemperature) {
  const Wrench squares = error_after({.drift = 1e-7, .temperature_rate = 0.01}, 30, Wrench::Zero());
  for (const double s : squares) EXPECT_CLOSE(s, std::pow(1e-7 * 0.01 * 30, 2), 2 * kFiveErrors);
}

TEST(ForceSensor, VibratesWithItsFrequencyAndSize) {
  const double size = 3e-7;
  for (const double frequency : {7.0, 50.0, 333.0, 500.0, 1234.5}) {
    ForceSensor sensor({.vibration = size, .vibration_frequency = frequency}, 1, 4);
    const Wrench still = sensor.read(Wrench::Zero(), 1e-3);
    EXPECT_EQ(still, Wrench(Wrench::Zero()));
    std::vector<double> x;
    double squares = 0;
    for (int n = 0; n < 20000; ++n) {
      x.push_back(sensor.read(Wrench::Zero(), 1e-3)[0]);
      squares += x.back() * x.back() / 20000;
    }
    if (frequency != 500) {  // where each reading is at the same phase, or the opposite
      EXPECT_CLOSE(squares, size * size, 0.01);
    }
    const double turn = 2 * std::cos(2 * std::numbers::pi * frequency * 1e-3);
    for (std::size_t n = 2; n < x.size(); ++n)
      EXPECT_NEAR(x[n], turn * x[n - 1] - x[n - 2], 1e-9 * size);
  }
}

TEST(ForceSensor, SaysHowFarItErrs) {
  const ForceSensorModel model{.noise = 3e-7, .bias = 4e-7};
  EXPECT_CLOSE(model.deviation(1e-5, 60), 5e-7, 1e-12);
  ForceSensorModel more = model;
  more.bias_walk = 1e-7;
  more.gain_error = 0.05;
  EXPECT_CLOSE(more.deviation(1e-5, 60), std::sqrt(25e-14 + 60e-14 + 25e-14), 1e-12);
}

// A pair interferes as often as the distributions say: the integral of the density of the fibre's
// diameter times the share of the bore's band below it.
TEST(DrawScene, PairsInterfereAsOftenAsTheirTolerancesSay) {
  Json document = testing::paper().document();
  const double sd = 0.25, low = 125.2, high = 126.4;
  document["tolerance"] = {{"fibre_diameter_sd_um", sd}, {"bore_diameter_um", {low, high}}};
  const Scene scene = parse_scene(document, "test");
  double expected = 0, all = 0;
  for (double u = -3 + 5e-4; u < 3; u += 1e-3) {
    const double density = std::exp(-0.5 * u * u);
    all += density;
    expected += density * std::clamp((125 + sd * u - low) / (high - low), 0.0, 1.0);
  }
  expected /= all;
  const int trials = 4000;
  int interfering = 0;
  for (int k = 0; k < trials; ++k) {
    const auto drawn = draw_scene(scene, 9, static_cast<std::uint64_t>(k));
    if (!drawn) {
      ++interfering;
      continue;
    }
    const double fibre = 2e6 * drawn->world.annulus.fibre_radius;
    const double bore = 2e6 * drawn->world.annulus.bore_radius;
    ASSERT_GT(bore, fibre);
    ASSERT_LE(std::abs(fibre - 125), 3 * sd);
    ASSERT_TRUE(bore >= low && bore <= high);
    EXPECT_TRUE(drawn->drawn.empty());
  }
  const double rate = static_cast<double>(interfering) / trials;
  EXPECT_LE(std::abs(rate - expected), 4 * std::sqrt(expected * (1 - expected) / trials));
  const Scene plain = testing::paper({"start.lateral_sd_um=0", "start.tilt_sd_mrad=0"});
  EXPECT_EQ(draw_scene(plain, 9, 1).get(), &plain);
}

}  // namespace
}  // namespace ferrule
