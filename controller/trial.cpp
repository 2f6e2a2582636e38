#include "controller/trial.hpp"

#include <cmath>
#include <limits>

#include "controller/joint_loss.hpp"
#include "sim/scene/draw.hpp"

namespace ferrule {

ControllerHand::ControllerHand(Controller& controller, const HandPose& start, double speed,
                               double end_depth)
    : controller_(controller), pose_(start), speed_(speed), end_depth_(end_depth) {}

HandSample ControllerHand::read(double t) {
  pose_ += velocity_ * (t - time_);
  time_ = t;
  const Supervision* supervision = controller_.supervision();
  if (supervision && supervision->gave_up) return {pose_, true, name(*supervision->gave_up)};
  return {pose_, hand_depth(pose_) >= end_depth_};
}

void ControllerHand::render(const HandWrench& wrench) {
  if (!felt_) at_rest_ = wrench;
  felt_ = true;
  velocity_ =
      limit_speed(controller_.command({wrench - at_rest_, hand_depth(pose_), time_}), speed_);
}

TrialResult run_trial(const Scene& toleranced, const Scaling& scaling, Controller& controller,
                      std::uint64_t seed, std::uint64_t trial, double period) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const std::shared_ptr<const Scene> drawn = draw_scene(toleranced, seed, trial);
  if (!drawn) return {Outcome::infeasible, {}, kNone, {}};
  const Scene& scene = *drawn;
  State state = draw_start(scene, seed, trial);
  ForceSensor sensor(scene.sensor, seed, trial);
  InsertionWatch watch(scene, state);
  ControllerHand hand(controller, scaling.motion_to_hand(state.command),
                      scaling.motion * scene.limits.speed, std::numeric_limits<double>::infinity());
  std::optional<Outcome> outcome;
  for (std::int64_t n = 0; !outcome; ++n) {
    const HandSample sample = hand.read(static_cast<double>(n) * period);
    if (sample.gave_up) {
      outcome = Outcome::gave_up;
      break;
    }
    const StepResult result =
        step(scene.world, state, scaling.motion_to_tip(sample.pose), n == 0 ? 0.0 : period);
    state = result.state;
    hand.render(scaling.wrench_to_hand(sensor.read(result.forces.holder, period)));
    outcome = watch.after(result);
  }
  TrialResult result{*outcome, watch.summary(), kNone, {}};
  if (const Supervision* supervision = controller.supervision()) result.supervision = *supervision;
  if (*outcome == Outcome::inserted)
    result.loss_dB = joint_loss_dB(result.summary.offset, result.summary.tilt);
  return result;
}

}  // namespace ferrule
