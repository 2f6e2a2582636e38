#include "insertion/simulated_operator.hpp"

#include "insertion/scene_scaling.hpp"
#include "sim/base/random.hpp"

namespace ferrule {
namespace {

constexpr double kPress = 0.6;  // 0.7 uN at the tip with the paper's scaling [N]

}  // namespace

TraineeTask trainee_task(const TrialSetup& trial, double period) noexcept {
  const Scene& scene = *trial.scene;
  const Scaling& scaling = trial.scaling;
  const double entrance = scene.start.distance - scene.sensor.entrance_error;
  const double distance = entrance + scene.success.depth + overshoot(scene);
  TraineeTask task = {trial.hand(),
                      scaling.motion * distance,
                      scaling.motion * scene.limits.speed,
                      kPress,
                      period,
                      scaling.motion * entrance,
                      {}};
  if (scene.start.vision && scene.start.distance > 0)
    task.aim = {
        scaling.motion * scene.start.distance,
        task.start.segment<2>(1) +
            scaling.motion * (*scene.start.vision - Vector2d(trial.start.tip.segment<2>(1)))};
  return task;
}

std::unique_ptr<Device> simulated_operator(const TrialSetup& trial, const OperatorSkill& skill,
                                           double period) {
  return std::make_unique<Trainee>(
      skill.traits(), trainee_task(trial, period),
      [random = RandomStream(trial.seed, trial.trial, Draw::operator_hand)]() mutable {
        return random.uniform();
      });
}

}  // namespace ferrule
