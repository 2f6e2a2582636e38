#include "insertion/loop.hpp"

#include "insertion/sensed_wrench.hpp"
#include "sim/held_stiffness.hpp"

namespace ferrule {
namespace {

constexpr const char* kNotFinite = "the hand's pose is not a finite number";

struct Held {
  HandSample sample;
  HandPose holder;
  bool trusted;
};

// The device's hand on the fibre's holder: by itself, or by way of force feedback.
class Grip {
 public:
  Grip(const Scene& scene, Device& device, const LoopSettings& settings)
      : scene_(scene),
        device_(device),
        settings_(settings),
        feedback_(settings.feedback),
        fibre_(settings.scaling, ForceSensor(), settings.period) {}

  // The hand at time t [s], which moves the holder of a fibre in `state` unless it is not trusted.
  Held read(double t, const State& state) {
    const HandSample sample = device_.read(t);
    const bool trusted = !feedback_ || feedback_->trusts(t, sample.age, sample.pose);
    if (trusted) holder_ = feedback_ ? feedback_->hold(sample.pose, stiffness(state)) : sample.pose;
    if (feedback_ && sample.stalled) feedback_->ramp_again(t);
    return {sample, holder_, trusted};
  }

  // The device renders the wrench `holder` of the fibre, of which the sensor reads `relative`.
  void render(double t, double age, const Wrench& holder, const HandWrench& relative) {
    if (!feedback_) return device_.render(relative);
    fibre_.read(holder, 0);
    device_.render(feedback_->feel(t, age, fibre_.relative(), relative));
  }

  void let_go() { device_.render(HandWrench::Zero()); }

  // Why the hand cannot be trusted; null where it can.
  const char* fault() const noexcept { return feedback_ ? feedback_->fault() : nullptr; }

 private:
  // Stiffness of the fibre at the holder, in the hand's world [N/m].
  Eigen::Matrix3d stiffness(const State& state) const noexcept {
    if (!feedback_->coupled()) return Eigen::Matrix3d::Zero();
    return settings_.scaling.force / settings_.scaling.motion *
           held_stiffness(scene_.world, state, settings_.period).topLeftCorner<3, 3>();
  }

  const Scene& scene_;
  Device& device_;
  const LoopSettings& settings_;
  ForceFeedback* feedback_;
  SensedWrench fibre_;  // as it is
  HandPose holder_ = HandPose::Zero();
};

}  // namespace

InsertionEnd run_insertion(const Scene& scene, const State& start, Device& hand,
                           const ForceSensor& sensor, const LoopSettings& settings,
                           const OnTick& on_tick) {
  const double period = settings.period;
  InsertionWatch watch(scene, start);
  SensedWrench sensed(settings.scaling, sensor, period, scene_tare(scene));
  Grip grip(scene, hand, settings);
  const auto end = [&](Outcome outcome, const char* why = "", bool lost = false) {
    return InsertionEnd{outcome, watch.summary(), why, lost, {}};
  };
  const auto past_success = [&](Outcome seen) {
    InsertionEnd ended = end(Outcome::inserted);
    ended.why = std::string("past the success depth: ") + name(seen);
    ended.afterwards = seen;
    return ended;
  };
  State state = start;
  HandTwist velocity = HandTwist::Zero();
  Outcome outcome = Outcome::stopped_short;
  Held now = grip.read(0, state);
  for (std::int64_t n = 0; n == 0 || !now.sample.finished; ++n) {
    const double t = static_cast<double>(n) * period;
    if (!now.trusted) {
      grip.let_go();
      return end(Outcome::interrupted, grip.fault());
    }
    const StepResult result =
        step(scene.world, state, settings.scaling.motion_to_tip(now.holder), n == 0 ? 0.0 : period);
    if (result.status == StepStatus::bad_command) return end(Outcome::invalid_output, kNotFinite);
    sensed.read(result.forces.holder, result.state.command[0]);
    grip.render(t, now.sample.age, result.forces.holder, sensed.relative());
    if (grip.fault()) return end(Outcome::interrupted, grip.fault());
    state = result.state;
    const std::optional<Outcome> seen = watch.after(result);
    const bool past = outcome == Outcome::inserted;  // what is seen now comes after success
    if (seen && !past) outcome = *seen;
    const bool over = seen && !(settings.past_success && *seen == Outcome::inserted);

    const Held next = grip.read(static_cast<double>(n + 1) * period, state);
    if (!next.holder.allFinite())
      return over ? past ? past_success(*seen) : end(outcome)
                  : end(Outcome::invalid_output, kNotFinite);
    const HandTwist command = (next.holder - now.holder) / period;
    const bool go_on = !on_tick || on_tick({t, now.sample, now.holder, velocity, command, result,
                                            sensed.absolute(), sensed.relative()});
    if (over) return past ? past_success(*seen) : end(outcome);
    if (next.sample.lost) return end(Outcome::interrupted, "the device was lost", true);
    if (!go_on) return end(Outcome::interrupted);
    if (settings.past_success && t >= scene.limits.time) return end(outcome);
    velocity = command;
    now = next;
  }
  if (now.sample.gave_up && outcome == Outcome::stopped_short)
    return end(Outcome::gave_up, now.sample.gave_up);
  return end(outcome);
}

}  // namespace ferrule
