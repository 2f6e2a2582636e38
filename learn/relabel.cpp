#include "learn/relabel.hpp"

#include "capture/session.hpp"
#include "capture/simulated_operator.hpp"
#include "controller/trial.hpp"

namespace ferrule {
namespace {

constexpr double kSkill = 0.8;

}  // namespace

Demonstration relabelled_trial(const Scene& scene, const Policy& policy, double reaction,
                               std::uint64_t seed, std::uint64_t trial) {
  const Scaling scaling = scene_scaling(scene);
  const State start = draw_start(scene, seed, trial);
  PolicyController controller(policy);
  ControllerHand hand(controller, scaling.motion_to_hand(start.hand),
                      scaling.motion * scene.limits.speed,
                      1.1 * scaling.motion * scene.success.depth);
  std::vector<RowVector> rows;
  Episode episode;
  episode.info.period = policy.period;
  episode.info.outcome = run_episode(
      scene, start, hand, policy.period, [&](const RowVector& row) { rows.push_back(row); },
      [] { return false; });

  TraineeTraits traits = trainee_traits(kSkill);
  traits.tremor = traits.hesitation_rate = 0;
  traits.delay = reaction;
  Trainee trainee(traits, trainee_task(scene, start, policy.period), [] { return 0.5; });
  episode.rows.resize(static_cast<Eigen::Index>(rows.size()), kRowSize);
  for (std::size_t n = 0; n < rows.size(); ++n) {
    const HandPose pose = block(rows[n], kHandPose).transpose();
    const HandWrench felt = scaling.wrench_to_hand(block(rows[n], kHolder).transpose());
    rows[n].segment<kPose>(kCommand.begin) =
        trainee.answer(rows[n][kTime.begin], pose, felt).transpose();
    episode.rows.row(static_cast<Eigen::Index>(n)) = rows[n];
  }
  return demonstration(episode, scene, "");
}

}  // namespace ferrule
