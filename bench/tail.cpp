#include "bench/tail.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "bench/random_scene.hpp"
#include "sim/analysis/hand_work.hpp"
#include "sim/base/measure.hpp"
#include "sim/scene/draw.hpp"
#include "sim/solver/step.hpp"

namespace ferrule {
namespace {

constexpr double kLongUs = 5;  // steps that take longer are measured again
constexpr int kAgain = 4;
constexpr double kLargestTilt = 0.5;  // a motion that turns the end farther ends there [rad]
constexpr double kMostSteps = 4000;   // of a motion in a random scene

struct Sample {
  TailRow row;
  std::vector<float> us;
  std::vector<int> evaluations;
};

// In place, as a loop takes it.
StepResult timed_step(const World& world, const StepResult& now, const Pose& hand, double dt,
                      double& us) {
  using Clock = std::chrono::steady_clock;
  StepResult result = now;
  const auto begin = Clock::now();
  step_on(world, hand, dt, result);
  us = std::chrono::duration<double, std::micro>(Clock::now() - begin).count();
  return result;
}

void drive(const Scene& scene, const State& start, const std::vector<Pose>& hand, double dt,
           Sample& sample) {
  const World& world = scene.world;
  StepResult now(start);
  HandWork work(world, start);
  for (const Pose& to : hand) {
    work.move(now.state, to);
    double us = 0;
    const StepResult result = timed_step(world, now, to, dt, us);
    for (int n = 0; n < kAgain && us > kLongUs; ++n) {
      double again = 0;
      timed_step(world, now, to, dt, again);
      us = std::min(us, again);
    }
    now = result;
    if (now.state.tip.tail<2>().norm() > kLargestTilt) return;
    ++sample.row.steps;
    sample.row.not_converged += result.status == StepStatus::not_converged;
    sample.row.capped += result.status == StepStatus::iteration_limit;
    sample.us.push_back(static_cast<float>(us));
    sample.evaluations.push_back(result.evaluations);
  }
  ++sample.row.loops;
  sample.row.loops_that_gained += work.gained(now.state);
}

template <class T>
T quantile(std::vector<T>& values, double part) {
  const auto at = static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

TailRow finished(Sample& sample) {
  TailRow& row = sample.row;
  row.p9999_us = quantile(sample.us, 0.9999);
  row.worst_us = quantile(sample.us, 1);
  row.evaluations_p9999 = quantile(sample.evaluations, 0.9999);
  row.evaluations_max = quantile(sample.evaluations, 1);
  return row;
}

TailRow shipped(const std::string& name, std::uint64_t seed, std::size_t starts) {
  const Scene scene = load_scene(name);
  Sample sample;
  sample.row.scene = name;
  for (std::size_t k = 0; k < starts; ++k) {
    const Motion motion = k % 2 ? Motion::press : Motion::insertion;
    const State start = draw_start(scene, seed, k);
    drive(scene, start, commands(scene, start, motion, 1e-3, seed, k), 1e-3, sample);
  }
  return finished(sample);
}

TailRow random(std::uint64_t seed, std::size_t scenes) {
  constexpr std::array<double, 5> steps = {1e-3, 1e-3, 1e-4, 3e-3, 1e-2};
  Sample sample;
  sample.row.scene = "random";
  for (std::size_t k = 0; k < scenes; ++k) {
    const Scene scene = random_scene(seed, k);
    for (int motion = 0; motion < kMotions; ++motion) {
      const State start = draw_start(scene, seed, k);
      const double dt = steps[k % steps.size()];
      const auto hand =
          commands(scene, start, static_cast<Motion>(motion), dt, seed, k, kMostSteps * dt);
      drive(scene, start, hand, dt, sample);
    }
  }
  return finished(sample);
}

}  // namespace

std::vector<TailRow> bench_tail(std::uint64_t seed, std::size_t scenes, const GoOn& go_on) {
  Cases<TailRow> cases;
  for (const std::string& name : shipped_scenes())
    add_case(cases, [=] { return shipped(name, seed, scenes); });
  add_case(cases, [=] { return random(seed, scenes); });
  return rows_of(cases, go_on);
}

}  // namespace ferrule
