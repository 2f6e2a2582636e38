#include "controller/stepped_trial.hpp"

#include "insertion/scene_scaling.hpp"

namespace ferrule {
// The hand that goes as it is told between the ticks.
class SteppedTrial::Hand : public Device {
 public:
  explicit Hand(const HandPose& start) : start_(start), pose_(start), holder_(start) {}
  HandSample read(double t) override {
    pose_ += velocity * (t - time_);
    time_ = t;
    return {pose_};
  }
  void render(const HandWrench&) override {}
  void holder_at(const HandPose& holder) override { holder_ = holder; }
  const HandPose& start() const noexcept { return start_; }
  const HandPose& holder() const noexcept { return holder_; }

  HandTwist velocity = HandTwist::Zero();

 private:
  HandPose start_, pose_, holder_;
  double time_ = 0;
};

struct SteppedTrial::Running {
  Running(const TrialSetup& of, double period)
      : trial(of),
        hand(trial.hand()),
        insertion(trial, hand, {.period = period, .past_success = false}) {}
  const TrialSetup trial;
  Hand hand;
  Insertion insertion;
};

SteppedTrial::SteppedTrial(std::shared_ptr<const Scene> scene, std::uint64_t seed,
                           std::uint64_t trial, double period)
    : scene_(std::move(scene)), drawn_(scene_), scaling_(scene_scaling(*scene_)) {
  const auto setup = trial_setup(*scene_, seed, trial);
  if (!setup) {
    ended_ = trial_result(*scene_, Outcome::infeasible, {});
    return;
  }
  drawn_ = setup->scene;
  entrance_ = registered_entrance(*drawn_);
  running_ = std::make_unique<Running>(*setup, period);
  running_->insertion.feel();
  expect_end();
}

SteppedTrial::~SteppedTrial() = default;

void SteppedTrial::step(const HandTwist& velocity) {
  if (ended_) return;
  Running& r = *running_;
  r.hand.velocity = limit_speed(velocity, scaling_.motion * drawn_->limits.speed);
  if (!r.insertion.answer()) r.insertion.feel();
  expect_end();
}

// A tick that ends the insertion is answered at once: by nobody.
void SteppedTrial::expect_end() {
  Insertion& insertion = running_->insertion;
  if (insertion.over() && !insertion.end()) insertion.answer();
  if (insertion.end())
    ended_ = trial_result(*drawn_, insertion.end()->outcome, insertion.end()->summary);
}

Observation SteppedTrial::observation() const noexcept {
  if (!running_) return {HandWrench::Zero(), 0, 0};
  const Running& r = *running_;
  return observe(r.insertion.sensed().relative(), r.hand.holder(), r.hand.start(), entrance_,
                 time(), scaling_.force * drawn_->limits.force);
}

HandWrench SteppedTrial::wrench() const noexcept {
  return running_ ? running_->insertion.sensed().absolute() : HandWrench::Zero();
}

double SteppedTrial::time() const noexcept {
  return running_ ? running_->insertion.time() : 0;
}

const StepResult& SteppedTrial::result() const noexcept {
  static const StepResult kNone{};
  return running_ ? running_->insertion.result() : kNone;
}

const InsertionSummary& SteppedTrial::summary() const noexcept {
  static const InsertionSummary kNone{};
  return running_ ? running_->insertion.summary() : kNone;
}

}  // namespace ferrule
