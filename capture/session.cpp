#include "capture/session.hpp"

namespace ferrule {

EpisodeEnd run_episode(const Scene& scene, const State& start, Device& device, ForceSensor sensor,
                       double period, const std::function<void(const RowVector&)>& record,
                       const std::function<bool()>& stop) {
  return run_episode(
      scene, start, device, std::move(sensor), period,
      [&](const RowVector& row, const RawCounts&) { record(row); }, stop);
}

EpisodeEnd run_episode(const Scene& scene, const State& start, Device& device, ForceSensor sensor,
                       double period,
                       const std::function<void(const RowVector&, const RawCounts&)>& record,
                       const std::function<bool()>& stop) {
  const Scaling scaling = scene_scaling(scene);
  InsertionWatch watch(scene, start);
  State state = start;
  Outcome outcome = Outcome::stopped_short;
  HandSample sample = device.read(0);
  HandTwist velocity = HandTwist::Zero();                      // over the period before
  for (std::int64_t n = 0; n == 0 || !sample.finished; ++n) {  // one row at least
    const double t = static_cast<double>(n) * period;
    const StepResult result =
        step(scene.world, state, scaling.motion_to_tip(sample.pose), n == 0 ? 0.0 : period);
    if (result.status == StepStatus::bad_command)
      return {Outcome::invalid_output, watch.summary(), {}};
    state = result.state;
    RowVector row = make_row(t, sample.pose, result);
    device.render(scaling.wrench_to_hand(sensor.read(result.forces.holder, period)));

    const std::optional<Outcome> now = watch.after(result);
    const HandSample next = device.read(static_cast<double>(n + 1) * period);
    const HandTwist command = (next.pose - sample.pose) / period;
    row.segment<kPose>(kHandVelocity.begin) = velocity.transpose();
    row.segment<kPose>(kCommand.begin) = command.transpose();
    record(row, sample.counts);
    if (now) outcome = *now;
    if (now && *now != Outcome::inserted) break;
    if (next.lost || stop()) {
      outcome = Outcome::interrupted;
      break;
    }
    if (t >= scene.limits.time) break;
    velocity = command;
    sample = next;
  }
  if (sample.gave_up && outcome == Outcome::stopped_short)
    return {Outcome::gave_up, watch.summary(), sample.gave_up};
  return {outcome, watch.summary(), {}};
}

}  // namespace ferrule
