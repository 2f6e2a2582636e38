#include "learn/relabel.hpp"

#include "capture/session.hpp"
#include "controller/trial.hpp"
#include "insertion/scene_scaling.hpp"
#include "insertion/simulated_operator.hpp"
#include "sim/scene/draw.hpp"

namespace ferrule {
namespace {

constexpr double kSkill = 0.8;

}  // namespace

Demonstration relabelled_trial(const Scene& scene, const Policy& policy, double reaction,
                               std::uint64_t seed, std::uint64_t trial) {
  const Scaling scaling = scene_scaling(scene);
  const State start = draw_start(scene, seed, trial);
  PolicyController controller(policy);
  ControllerHand hand(controller, scaling.motion_to_hand(start.command),
                      scaling.motion * scene.limits.speed,
                      1.1 * scaling.motion * scene.success.depth);
  std::vector<RowVector> rows;
  Episode episode;
  episode.info.seed = seed;
  episode.info.trial = trial;
  episode.info.period = policy.period;
  const EpisodeEnd end = run_episode(
      scene, start, hand, ForceSensor(scene.sensor, seed, trial), policy.period,
      [&](const RowVector& row) { rows.push_back(row); }, [] { return false; });
  episode.info.outcome = end.outcome;

  TraineeTraits traits = trainee_traits(kSkill);
  traits.tremor = traits.hesitation_rate = 0;
  traits.delay = reaction;
  Trainee trainee(traits, trainee_task(scene, start, policy.period), [] { return 0.5; });
  episode.rows.resize(static_cast<Eigen::Index>(rows.size()), kRowSize);
  for (std::size_t n = 0; n < rows.size(); ++n)
    episode.rows.row(static_cast<Eigen::Index>(n)) = rows[n];
  const auto felt = felt_wrench(episode, scene);
  for (std::size_t n = 0; n < rows.size(); ++n) {
    const auto row = static_cast<Eigen::Index>(n);
    const HandPose pose = block(rows[n], kHandPose).transpose();
    episode.rows.row(row).segment<kPose>(kCommand.begin) =
        trainee.answer(rows[n][kTime.begin], pose, felt.row(row).transpose()).transpose();
  }
  return demonstration(episode, scene, "");
}

}  // namespace ferrule
