#include "insertion/simulated_operator.hpp"

#include "insertion/scene_scaling.hpp"
#include "sim/base/random.hpp"
#include "sim/scene/draw.hpp"

namespace ferrule {
namespace {

constexpr double kPress = 0.6;  // 0.7 uN at the tip with the paper's scaling [N]

}  // namespace

TraineeTask trainee_task(const Scene& scene, const State& start, double period) noexcept {
  const Scaling scaling = scene_scaling(scene);
  const double entrance = scene.start.distance - scene.sensor.entrance_error;
  const double distance = entrance + scene.success.depth + overshoot(scene);
  TraineeTask task = {scaling.motion_to_hand(start.command),
                      scaling.motion * distance,
                      scaling.motion * scene.limits.speed,
                      kPress,
                      period,
                      scaling.motion * entrance,
                      {}};
  if (scene.start.vision && scene.start.distance > 0)
    task.aim = {scaling.motion * scene.start.distance,
                task.start.segment<2>(1) +
                    scaling.motion * (*scene.start.vision - Vector2d(start.tip.segment<2>(1)))};
  return task;
}

std::unique_ptr<Device> simulated_operator(const Scene& scene, const State& start,
                                           const OperatorSkill& skill, double period,
                                           std::uint64_t seed, std::uint64_t trial) {
  return std::make_unique<Trainee>(
      skill.traits(), trainee_task(scene, start, period),
      [random = RandomStream(seed, trial, Draw::operator_hand)]() mutable {
        return random.uniform();
      });
}

std::unique_ptr<Device> operator_of_trial(const Scene& toleranced, const OperatorSkill& skill,
                                          double period, std::uint64_t seed, std::uint64_t trial) {
  const auto drawn = draw_scene(toleranced, seed, trial);
  const Scene& scene = drawn ? *drawn : toleranced;
  return simulated_operator(scene, draw_start(scene, seed, trial), skill, period, seed, trial);
}

}  // namespace ferrule
