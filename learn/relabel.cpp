#include "learn/relabel.hpp"

#include "controller/searching_operator.hpp"
#include "controller/trial.hpp"
#include "insertion/scene_scaling.hpp"
#include "insertion/simulated_operator.hpp"

namespace ferrule {
namespace {

// What he would do, asked at every tick.
using Teacher = std::function<HandTwist(const Tick&, const Observation&)>;

Teacher teacher_of(const SimulatedOperator& operator_, const Scene& scene, const TraineeTask& task,
                   double reaction) {
  TraineeTraits traits = operator_.skill.traits();
  traits.tremor = traits.hesitation_rate = 0;
  traits.delay = reaction;
  const auto steady = [] { return 0.5; };
  if (!operator_.searches)
    return [trainee = Trainee(traits, task, steady)](const Tick& tick, const Observation&) mutable {
      return trainee.answer(tick.time, tick.hand, tick.relative);
    };
  traits.delay = std::max(traits.delay, task.period);
  return [his = std::shared_ptr(searching_operator(scene, traits, task.period, steady))](
             const Tick&, const Observation& observation) { return his->command(observation); };
}

}  // namespace

Demonstration relabelled_trial(const Scene& toleranced, const Policy& policy,
                               const SimulatedOperator& teacher, double reaction,
                               std::uint64_t seed, std::uint64_t first) {
  const TrialSetup setup = feasible_setup(toleranced, seed, first);
  const Scene& scene = *setup.scene;
  PolicyController controller(policy);
  ControllerHand hand = recorded_hand(setup, controller);
  const Teacher ask = teacher_of(teacher, scene, trainee_task(setup, policy.period), reaction);
  const Eigen::Index stride = rows_per_step(policy.period);
  Eigen::Index n = 0;
  Demonstration d;
  d.period = static_cast<double>(stride) * policy.period;
  d.speed_limit = setup.scaling.motion * scene.limits.speed;
  HandPose begun;
  std::vector<HandTwist> answers;
  d.outcome = run_insertion(setup, hand, {.period = policy.period, .past_success = true},
                            [&](const Tick& tick) {
                              if (n == 0) begun = tick.hand;
                              const Observation observed =
                                  observe(tick.relative, tick.hand, begun,
                                          registered_entrance(scene), tick.time);
                              const HandTwist answer = ask(tick, observed);
                              if (n++ % stride != 0) return true;
                              d.observations.push_back(observed);
                              answers.push_back(answer);
                              return true;
                            })
                  .outcome;
  d.velocity.resize(static_cast<Eigen::Index>(answers.size()), Eigen::NoChange);
  d.tilt_rates.resize(d.velocity.rows(), Eigen::NoChange);
  for (std::size_t i = 0; i < answers.size(); ++i) {
    d.velocity.row(static_cast<Eigen::Index>(i)) = answers[i].head<3>();
    d.tilt_rates.row(static_cast<Eigen::Index>(i)) = answers[i].tail<2>();
  }
  return d;
}

}  // namespace ferrule
