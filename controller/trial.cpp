#include "controller/trial.hpp"

#include <algorithm>
#include <limits>

#include "insertion/scene_scaling.hpp"

namespace ferrule {

ControllerHand::ControllerHand(Controller& controller, const HandPose& start, double speed,
                               double end_depth, double entrance, double force_limit)
    : controller_(controller),
      start_(start),
      pose_(start),
      holder_(start),
      speed_(speed),
      end_depth_(end_depth),
      entrance_(entrance),
      force_limit_(force_limit) {}

HandSample ControllerHand::read(double t) {
  pose_ += velocity_ * (t - time_);
  const double within_tick = speed_ * (t - time_);
  time_ = t;
  const Supervision* supervision = controller_.supervision();
  if (supervision && supervision->gave_up) return {pose_, true, name(*supervision->gave_up)};
  const double depth =
      std::min(hand_depth(pose_, entrance_), hand_depth(holder_, entrance_) + within_tick);
  return {pose_, controller_.done() || depth >= end_depth_};
}

void ControllerHand::render(const HandWrench& wrench) {
  const Observation now = observe(wrench, holder_, start_, entrance_, time_, force_limit_);
  velocity_ = limit_speed(controller_.command(now), speed_);
}

ControllerHand recorded_hand(const TrialSetup& trial, Controller& controller) {
  const Scene& scene = *trial.scene;
  return {controller,
          trial.hand(),
          trial.scaling.motion * scene.limits.speed,
          1.1 * trial.scaling.motion * scene.success.depth,
          registered_entrance(scene),
          trial.scaling.force * scene.limits.force};
}

TrialResult trial_result(const Scene& scene, Outcome outcome,
                         const InsertionSummary& summary) noexcept {
  const LightAxis light = light_axis(scene.joint, summary.tip);
  const double loss = outcome == Outcome::inserted || outcome == Outcome::high_loss
                          ? joint_loss_dB(scene.joint, light)
                          : std::numeric_limits<double>::quiet_NaN();
  return {outcome, summary, loss, {}, {}, light};
}

namespace {

TrialResult with_supervision(TrialResult result, const Controller& controller) {
  if (const Supervision* supervision = controller.supervision()) result.supervision = *supervision;
  return result;
}

}  // namespace

TrialResult run_trial(const TrialSetup& trial, Controller& controller, double period,
                      const OnTick& on_tick, const std::function<bool()>& stop) {
  const Scene& scene = *trial.scene;
  ControllerHand hand(controller, trial.hand(), trial.scaling.motion * scene.limits.speed,
                      std::numeric_limits<double>::infinity(), registered_entrance(scene),
                      trial.scaling.force * scene.limits.force);
  const InsertionEnd end =
      run_insertion(trial, hand, {.period = period, .past_success = false, .stop = stop}, on_tick);
  TrialResult result = with_supervision(trial_result(scene, end.outcome, end.summary), controller);
  result.why = controller.failure();
  return result;
}

TrialResult run_trial(const Scene& scene, Controller& controller, std::uint64_t seed,
                      std::uint64_t trial, double period, const OnTick& on_tick,
                      const std::function<bool()>& stop, const std::string& redrawn) {
  if (const auto setup = trial_setup(scene, seed, trial, redrawn))
    return run_trial(*setup, controller, period, on_tick, stop);
  return with_supervision(trial_result(scene, Outcome::infeasible, {}), controller);
}

}  // namespace ferrule
