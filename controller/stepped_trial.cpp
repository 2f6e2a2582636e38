#include "controller/stepped_trial.hpp"

#include "insertion/scene_scaling.hpp"
#include "sim/scene/draw.hpp"

namespace ferrule {
// The hand that goes as it is told between the ticks.
class SteppedTrial::Hand : public Device {
 public:
  explicit Hand(const HandPose& start) : pose_(start) {}
  HandSample read(double t) override {
    pose_ += velocity * (t - time_);
    time_ = t;
    return {pose_};
  }
  void render(const HandWrench&) override {}
  const HandPose& pose() const noexcept { return pose_; }

  HandTwist velocity = HandTwist::Zero();

 private:
  HandPose pose_;
  double time_ = 0;
};

struct SteppedTrial::Running {
  Running(const Scene& scene, const State& start, const ForceSensor& sensor,
          const LoopSettings& settings)
      : hand(settings.scaling.motion_to_hand(start.command)),
        insertion(scene, start, hand, sensor, settings) {}
  Hand hand;
  Insertion insertion;
};

SteppedTrial::SteppedTrial(std::shared_ptr<const Scene> scene, std::uint64_t seed,
                           std::uint64_t trial, double period)
    : scene_(std::move(scene)),
      drawn_(draw_scene(*scene_, seed, trial)),
      scaling_(scene_scaling(*scene_)),
      period_(period) {
  if (!drawn_) {
    drawn_ = scene_;
    ended_ = trial_result(Outcome::infeasible, {});
    return;
  }
  const State start = draw_start(*drawn_, seed, trial);
  running_ = std::make_unique<Running>(
      *drawn_, start, ForceSensor(drawn_->sensor, seed, trial),
      LoopSettings{.scaling = scaling_, .period = period_, .past_success = false});
  running_->insertion.feel();
  take_over();
}

SteppedTrial::~SteppedTrial() = default;

void SteppedTrial::step(const HandTwist& velocity) {
  if (ended_) return;
  Running& r = *running_;
  r.hand.velocity = limit_speed(velocity, scaling_.motion * drawn_->limits.speed);
  if (!r.insertion.answer()) r.insertion.feel();
  take_over();
}

// What the last tick came to. One that ends the insertion is answered at once: by nobody.
void SteppedTrial::take_over() {
  Running& r = *running_;
  Insertion& insertion = r.insertion;
  if (insertion.over() && !insertion.end()) insertion.answer();
  const SensedWrench& sensed = insertion.sensed();
  observation_ = {sensed.relative(), hand_depth(r.hand.pose(), registered_entrance(*drawn_)),
                  insertion.time()};
  wrench_ = sensed.absolute();
  result_ = insertion.result();
  summary_ = insertion.summary();
  if (insertion.end()) ended_ = trial_result(insertion.end()->outcome, insertion.end()->summary);
}

}  // namespace ferrule
