#include "learn/relabel.hpp"

#include "controller/trial.hpp"
#include "insertion/scene_scaling.hpp"
#include "insertion/simulated_operator.hpp"
#include "sim/scene/draw.hpp"

namespace ferrule {

Demonstration relabelled_trial(const Scene& toleranced, const Policy& policy, double skill,
                               double reaction, std::uint64_t seed, std::uint64_t first) {
  const auto [drawn, trial, infeasible] = feasible_trial(toleranced, seed, first);
  const Scene& scene = *drawn;
  const Scaling scaling = scene_scaling(scene);
  const State start = draw_start(scene, seed, trial);
  PolicyController controller(policy);
  ControllerHand hand(controller, scaling.motion_to_hand(start.command),
                      scaling.motion * scene.limits.speed,
                      1.1 * scaling.motion * scene.success.depth, registered_entrance(scene));
  TraineeTraits traits = trainee_traits(skill);
  traits.tremor = traits.hesitation_rate = 0;
  traits.delay = reaction;
  Trainee trainee(traits, trainee_task(scene, start, policy.period, seed, trial),
                  [] { return 0.5; });
  Demonstration d;
  d.period = policy.period;
  d.speed_limit = scaling.motion * scene.limits.speed;
  std::vector<Eigen::Vector3d> answers;
  d.outcome =
      run_insertion(
          scene, start, hand, ForceSensor(scene.sensor, seed, trial),
          {.scaling = scaling, .period = policy.period, .past_success = true},
          [&](const Tick& tick) {
            d.observations.push_back(
                {tick.relative, hand_depth(tick.hand, registered_entrance(scene)), tick.time});
            answers.push_back(trainee.answer(tick.time, tick.hand, tick.relative).head<3>());
            return true;
          })
          .outcome;
  d.velocity.resize(static_cast<Eigen::Index>(answers.size()), Eigen::NoChange);
  for (std::size_t n = 0; n < answers.size(); ++n)
    d.velocity.row(static_cast<Eigen::Index>(n)) = answers[n].transpose();
  return d;
}

}  // namespace ferrule
