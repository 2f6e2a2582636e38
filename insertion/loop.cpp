#include "insertion/loop.hpp"

#include "insertion/imperfect_hand.hpp"
#include "insertion/sensed_wrench.hpp"
#include "sim/solver/held_stiffness.hpp"

namespace ferrule {
namespace {

constexpr const char* kNotFinite = "the hand's pose is not a finite number";
constexpr std::int64_t kStopEvery = 64;  // ticks

}  // namespace

struct Insertion::Held {
  HandSample sample;
  HandPose holder;
  bool trusted;
};

// The device's hand on the fibre's holder: by itself, or by way of force feedback.
class Insertion::Grip {
 public:
  Grip(const TrialSetup& trial, Device& device, const LoopSettings& settings)
      : trial_(trial),
        device_(device),
        period_(settings.period),
        feedback_(settings.feedback),
        moved_(settings.recorded ? HandErrors() : trial.scene->hand, trial.scaling, period_),
        fibre_(trial.scaling, ForceSensor(), period_) {}

  // The hand at time t [s], which moves the holder of a fibre in `state` unless it is not trusted.
  Held read(double t, const State& state) {
    const HandSample sample = device_.read(t);
    const bool trusted = !feedback_ || feedback_->trusts(t, sample.age, sample.pose);
    if (trusted) {
      holder_ = moved_.holder(sample.pose);
      if (feedback_) holder_ = feedback_->hold(holder_, stiffness(state));
    }
    if (feedback_ && sample.stalled) feedback_->ramp_again(t);
    return {sample, holder_, trusted};
  }

  // The device renders the wrench `holder` of the fibre, of which the sensor reads `relative`.
  void render(double t, double age, const Wrench& holder, const HandWrench& relative) {
    device_.holder_at(holder_);
    if (!feedback_) return device_.render(relative);
    fibre_.read(holder, 0);
    device_.render(feedback_->feel(t, age, fibre_.relative(), relative));
  }

  void release() { device_.render(HandWrench::Zero()); }

  // Why the hand cannot be trusted; null where it can.
  const char* fault() const noexcept { return feedback_ ? feedback_->fault() : nullptr; }

 private:
  // Stiffness of the fibre at the holder, in the hand's world [N/m].
  Eigen::Matrix3d stiffness(const State& state) const noexcept {
    if (!feedback_->coupled()) return Eigen::Matrix3d::Zero();
    return trial_.scaling.force / trial_.scaling.motion *
           held_stiffness(trial_.scene->world, state, period_).topLeftCorner<3, 3>();
  }

  const TrialSetup& trial_;
  Device& device_;
  double period_;  // [s]
  ForceFeedback* feedback_;
  ImperfectHand moved_;
  SensedWrench fibre_;  // as it is
  HandPose holder_ = HandPose::Zero();
};

struct Insertion::Parts {
  Parts(const TrialSetup& trial, Device& hand, const LoopSettings& with)
      : scene(*trial.scene),
        scaling(trial.scaling),
        settings(with),
        watch(scene, trial.start),
        sensed(scaling, trial.sensor, with.period, scene_tare(scene)),
        grip(trial, hand, with),
        result(trial.start),
        now(grip.read(0, trial.start)) {}

  // What comes after success does not undo it.
  const std::optional<InsertionEnd>& ends(Outcome how, std::string why = "", bool lost = false) {
    const bool after = outcome == Outcome::inserted && how != outcome;
    if (after) why = "past the success depth: " + (why.empty() ? name(how) : why);
    ended = InsertionEnd{after ? outcome : how, watch.summary(), std::move(why), lost, {}};
    if (after) ended->afterwards = how;
    return ended;
  }
  double time() const noexcept { return static_cast<double>(ticks) * settings.period; }

  const Scene& scene;
  const Scaling scaling;
  const LoopSettings settings;
  InsertionWatch watch;
  SensedWrench sensed;
  Grip grip;
  StepResult result;
  Held now;
  HandTwist velocity = HandTwist::Zero();
  std::int64_t ticks = 0;
  Outcome outcome = Outcome::stopped_short;
  std::optional<Outcome> seen;  // in this tick
  bool over = false;            // what is seen ends the insertion
  std::optional<InsertionEnd> ended;
};

Insertion::Insertion(const TrialSetup& trial, Device& hand, const LoopSettings& settings)
    : parts_(std::make_unique<Parts>(trial, hand, settings)) {}
Insertion::~Insertion() = default;

double Insertion::time() const noexcept {
  return parts_->time();
}
const StepResult& Insertion::result() const noexcept {
  return parts_->result;
}
const SensedWrench& Insertion::sensed() const noexcept {
  return parts_->sensed;
}
bool Insertion::over() const noexcept {
  return parts_->over;
}
const std::optional<InsertionEnd>& Insertion::end() const noexcept {
  return parts_->ended;
}
const InsertionSummary& Insertion::summary() const noexcept {
  return parts_->watch.summary();
}

const std::optional<InsertionEnd>& Insertion::feel() {
  Parts& p = *parts_;
  if (!p.now.trusted) {
    p.grip.release();
    return p.ends(Outcome::interrupted, p.grip.fault());
  }
  step_on(p.scene.world, p.scaling.motion_to_tip(p.now.holder),
          p.ticks == 0 ? 0.0 : p.settings.period, p.result);
  if (p.result.status == StepStatus::bad_command)
    return p.ends(Outcome::invalid_output, kNotFinite);
  p.sensed.read(p.result.holder, p.result.state.command[0]);
  p.grip.render(p.time(), p.now.sample.age, p.result.holder, p.sensed.relative());
  if (p.grip.fault()) return p.ends(Outcome::interrupted, p.grip.fault());
  p.seen = p.watch.after(p.result);
  if (p.seen && p.outcome != Outcome::inserted) p.outcome = *p.seen;
  p.over = p.seen && !(p.settings.past_success && *p.seen == Outcome::inserted);
  return p.ended;
}

const std::optional<InsertionEnd>& Insertion::answer(const OnTick& on_tick) {
  Parts& p = *parts_;
  const double period = p.settings.period;
  const Held next = p.grip.read(static_cast<double>(p.ticks + 1) * period, p.result.state);
  if (!next.holder.allFinite())
    return p.over ? p.ends(*p.seen) : p.ends(Outcome::invalid_output, kNotFinite);
  const HandTwist command = (next.holder - p.now.holder) / period;
  const bool go_on = !on_tick || on_tick({p.time(), p.now.sample, p.now.holder, p.velocity, command,
                                          p.result, forces(p.scene.world, p.result),
                                          p.sensed.absolute(), p.sensed.relative()});
  if (p.over) return p.ends(*p.seen);
  if (next.sample.lost) return p.ends(Outcome::interrupted, "the device was lost", true);
  const bool stopped = p.ticks % kStopEvery == 0 && p.settings.stop && p.settings.stop();
  if (!go_on || stopped) return p.ends(Outcome::interrupted);
  if (p.settings.past_success && p.time() >= p.scene.limits.time) return p.ends(p.outcome);
  p.velocity = command;
  p.now = next;
  ++p.ticks;
  if (!next.sample.finished) return p.ended;
  if (next.sample.gave_up && p.outcome == Outcome::stopped_short)
    return p.ends(Outcome::gave_up, next.sample.gave_up);
  return p.ends(p.outcome);
}

InsertionEnd run_insertion(const TrialSetup& trial, Device& hand, const LoopSettings& settings,
                           const OnTick& on_tick) {
  Insertion insertion(trial, hand, settings);
  while (!insertion.feel() && !insertion.answer(on_tick)) {
  }
  return *insertion.end();
}

}  // namespace ferrule
