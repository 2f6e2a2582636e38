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
  ControllerHand hand = recorded_hand(scene, start, controller);
  TraineeTraits traits = trainee_traits(skill);
  traits.tremor = traits.hesitation_rate = 0;
  traits.delay = reaction;
  Trainee trainee(traits, trainee_task(scene, start, policy.period, seed, trial),
                  [] { return 0.5; });
  const Eigen::Index stride = rows_per_step(policy.period);
  Eigen::Index n = 0;
  Demonstration d;
  d.period = static_cast<double>(stride) * policy.period;
  d.speed_limit = scaling.motion * scene.limits.speed;
  HandPose begun;
  std::vector<Eigen::Vector3d> answers;
  d.outcome =
      run_insertion(scene, start, hand, ForceSensor(scene.sensor, seed, trial),
                    {.scaling = scaling, .period = policy.period, .past_success = true},
                    [&](const Tick& tick) {
                      const HandTwist answer = trainee.answer(tick.time, tick.hand, tick.relative);
                      if (n++ % stride != 0) return true;
                      if (d.observations.empty()) begun = tick.hand;
                      d.observations.push_back(observe(tick.relative, tick.hand, begun,
                                                       registered_entrance(scene), tick.time));
                      answers.push_back(answer.head<3>());
                      return true;
                    })
          .outcome;
  d.velocity.resize(static_cast<Eigen::Index>(answers.size()), Eigen::NoChange);
  d.tilt_rates.setZero(d.velocity.rows(), Eigen::NoChange);
  for (std::size_t i = 0; i < answers.size(); ++i)
    d.velocity.row(static_cast<Eigen::Index>(i)) = answers[i].transpose();
  return d;
}

}  // namespace ferrule
