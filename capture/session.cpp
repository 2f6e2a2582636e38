#include "capture/session.hpp"

#include "insertion/scene_scaling.hpp"
#include "sim/held_stiffness.hpp"

namespace ferrule {
namespace {

constexpr const char* kNotFinite = "the hand's pose is not a finite number";

}  // namespace

EpisodeEnd run_episode(const Scene& scene, const State& start, Device& device, ForceSensor sensor,
                       double period, const std::function<void(const RowVector&)>& record,
                       const std::function<bool()>& stop, ForceFeedback* feedback) {
  return run_episode(
      scene, start, device, std::move(sensor), period,
      [&](const RowVector& row, const RawCounts&) { record(row); }, stop, feedback);
}

EpisodeEnd run_episode(const Scene& scene, const State& start, Device& device, ForceSensor sensor,
                       double period,
                       const std::function<void(const RowVector&, const RawCounts&)>& record,
                       const std::function<bool()>& stop, ForceFeedback* feedback) {
  const Scaling scaling = scene_scaling(scene);
  InsertionWatch watch(scene, start);
  State state = start;
  // Where a hand at `pose` has the fibre's holder.
  const auto holder = [&](const HandPose& pose) {
    if (!feedback) return pose;
    Eigen::Matrix3d stiffness = Eigen::Matrix3d::Zero();
    if (feedback->coupled())
      stiffness = scaling.force / scaling.motion *
                  held_stiffness(scene.world, state, period).topLeftCorner<3, 3>();
    return feedback->hold(pose, stiffness);
  };
  const auto trusts = [&](double t, const HandSample& read) {
    return !feedback || feedback->trusts(t, read.age, read.pose);
  };
  Outcome outcome = Outcome::stopped_short;
  HandSample sample = device.read(0);
  bool trusted = trusts(0, sample);
  HandPose pose = holder(sample.pose);
  HandTwist velocity = HandTwist::Zero();                      // over the period before
  for (std::int64_t n = 0; n == 0 || !sample.finished; ++n) {  // one row at least
    const double t = static_cast<double>(n) * period;
    if (feedback && sample.stalled) feedback->ramp_again(t);
    if (!trusted) {
      device.render(HandWrench::Zero());
      return {Outcome::interrupted, watch.summary(), feedback->fault()};
    }
    const StepResult result =
        step(scene.world, state, scaling.motion_to_tip(pose), n == 0 ? 0.0 : period);
    if (result.status == StepStatus::bad_command)
      return {Outcome::invalid_output, watch.summary(), kNotFinite};
    const HandWrench reading = scaling.wrench_to_hand(sensor.read(result.forces.holder, period));
    device.render(feedback ? feedback->feel(t, sample.age,
                                            scaling.wrench_to_hand(result.forces.holder), reading)
                           : reading);
    if (feedback && feedback->fault())
      return {Outcome::interrupted, watch.summary(), feedback->fault()};
    state = result.state;
    RowVector row = make_row(t, pose, result);

    const std::optional<Outcome> now = watch.after(result);
    const HandSample next = device.read(static_cast<double>(n + 1) * period);
    trusted = trusts(static_cast<double>(n + 1) * period, next);
    const HandPose next_pose = trusted ? holder(next.pose) : pose;
    if (!next_pose.allFinite()) return {Outcome::invalid_output, watch.summary(), kNotFinite};
    const HandTwist command = (next_pose - pose) / period;
    row.segment<kPose>(kHandVelocity.begin) = velocity.transpose();
    row.segment<kPose>(kCommand.begin) = command.transpose();
    record(row, sample.counts);
    if (now) outcome = *now;
    if (now && *now != Outcome::inserted) break;
    if (next.lost) return {Outcome::interrupted, watch.summary(), "the device was lost", true};
    if (stop()) {
      outcome = Outcome::interrupted;
      break;
    }
    if (t >= scene.limits.time) break;
    velocity = command;
    sample = next;
    pose = next_pose;
  }
  if (sample.gave_up && outcome == Outcome::stopped_short)
    return {Outcome::gave_up, watch.summary(), sample.gave_up};
  return {outcome, watch.summary(), {}};
}

ForceFeedback force_feedback(const Scene& scene, const State& start, const DeviceProfile& device,
                             const std::optional<Coupling>& coupling, double report_period,
                             const Eigen::Vector3d& motors) {
  const Scaling scaling = scene_scaling(scene);
  const Wrench rest = step(scene.world, start, start.command, 0).forces.holder;
  return {
      device,        coupling, scaling.motion_to_hand(start.command), scaling.wrench_to_hand(rest),
      report_period, motors};
}

}  // namespace ferrule
