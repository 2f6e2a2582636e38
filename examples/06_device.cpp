// A device of one's own in the loop with the simulator. A device is two functions, called in turn
// once per period: where the hand is, and what the hand feels there.
#include <cstdio>

#include "insertion/loop.hpp"

using namespace ferrule;

// Stands for hardware: a hand that goes straight in, and lets itself be pushed aside.
class SoftHand : public Device {
 public:
  SoftHand(const HandPose& start, double speed, double end)
      : pose_(start), speed_(speed), end_(end) {}

  // Where the hand is at `t` [s], in the hand's world [m, rad].
  HandSample read(double t) override {
    pose_[0] -= speed_ * (t - time_);
    pose_.segment<2>(1) += kMobility * (t - time_) * felt_.segment<2>(1);
    time_ = t;
    HandSample sample;
    sample.pose = pose_;
    sample.finished = pose_[0] < -end_;
    return sample;
  }
  // What it feels there [N, N m].
  void render(const HandWrench& wrench) override {
    felt_ = wrench;
    largest_ = std::max(largest_, wrench.norm());
  }
  double largest() const { return largest_; }

 private:
  static constexpr double kMobility = 0.01;  // [m/s per N]
  HandPose pose_;
  HandWrench felt_ = HandWrench::Zero();
  double speed_, end_, time_ = 0, largest_ = 0;
};

int main() {
  const Scene scene = load_scene("demo");
  const TrialSetup trial = feasible_setup(scene, 1, 1);
  SoftHand hand(trial.hand(), 0.5 * trial.scaling.motion * scene.limits.speed,
                1.1 * trial.scaling.motion * scene.success.depth);
  std::size_t ticks = 0;
  const InsertionEnd end =
      run_insertion(trial, hand, {.past_success = true}, [&](const Tick&) { return ++ticks > 0; });
  std::printf("%s after %.2f s, %zu ticks; the hand felt %.2f N at most\n", name(end.outcome),
              end.summary.time, ticks, hand.largest());
  return end.outcome == Outcome::inserted && hand.largest() > 0 ? 0 : 1;
}
