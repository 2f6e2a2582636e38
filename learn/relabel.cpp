#include "learn/relabel.hpp"

#include "controller/trial.hpp"
#include "insertion/scene_scaling.hpp"
#include "insertion/simulated_operator.hpp"
#include "sim/scene/draw.hpp"

namespace ferrule {
namespace {

constexpr double kSkill = 0.8;

// What the trainee does at one tick.
struct Answer {
  double time, depth;
  HandWrench wrench;
  HandTwist velocity;
};

Demonstration demonstration(const std::vector<Answer>& answers, Outcome outcome, double period,
                            double speed_limit) {
  Demonstration d{"", "", outcome, period, speed_limit, {}, {}, {}, {}, {}};
  const auto count = static_cast<Eigen::Index>(answers.size());
  for (auto* columns : {&d.force, &d.velocity}) columns->resize(count, Eigen::NoChange);
  d.moment.resize(count, Eigen::NoChange);
  for (auto* column : {&d.depth, &d.time}) column->resize(count);
  for (Eigen::Index n = 0; n < count; ++n) {
    const Answer& a = answers[static_cast<std::size_t>(n)];
    d.force.row(n) = a.wrench.head<3>().transpose();
    d.moment.row(n) = a.wrench.tail<2>().transpose();
    d.velocity.row(n) = a.velocity.head<3>().transpose();
    d.depth[n] = a.depth;
    d.time[n] = a.time;
  }
  return d;
}

}  // namespace

Demonstration relabelled_trial(const Scene& scene, const Policy& policy, double reaction,
                               std::uint64_t seed, std::uint64_t trial) {
  const Scaling scaling = scene_scaling(scene);
  const State start = draw_start(scene, seed, trial);
  PolicyController controller(policy);
  ControllerHand hand(controller, scaling.motion_to_hand(start.command),
                      scaling.motion * scene.limits.speed,
                      1.1 * scaling.motion * scene.success.depth);
  TraineeTraits traits = trainee_traits(kSkill);
  traits.tremor = traits.hesitation_rate = 0;
  traits.delay = reaction;
  Trainee trainee(traits, trainee_task(scene, start, policy.period), [] { return 0.5; });
  std::vector<Answer> answers;
  const InsertionEnd end = run_insertion(
      scene, start, hand, ForceSensor(scene.sensor, seed, trial),
      {.scaling = scaling, .period = policy.period, .past_success = true}, [&](const Tick& tick) {
        answers.push_back({tick.time, hand_depth(tick.hand), tick.relative,
                           trainee.answer(tick.time, tick.hand, tick.relative)});
        return true;
      });
  return demonstration(answers, end.outcome, policy.period, scaling.motion * scene.limits.speed);
}

}  // namespace ferrule
