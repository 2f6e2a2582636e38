// A trial that somebody else steps: what a controller answers inside of run_trial, a program says
// from outside, period by period, with the same bits.
#pragma once

#include <memory>

#include "controller/observation.hpp"
#include "controller/trial.hpp"
#include "sim/base/control_period.hpp"

namespace ferrule {

class SteppedTrial {
 public:
  // Trial `trial` of a campaign under `seed`, at its start: the fibre at rest, felt once. Where the
  // drawn parts do not fit it has ended as `infeasible`. `period` [s]. Throws BadInput if the
  // scene cannot be with the drawn diameters.
  SteppedTrial(std::shared_ptr<const Scene> scene, std::uint64_t seed, std::uint64_t trial,
               double period = kControlPeriod);
  ~SteppedTrial();
  SteppedTrial(const SteppedTrial&) = delete;
  SteppedTrial& operator=(const SteppedTrial&) = delete;

  // Moves the hand by `velocity` [m/s, rad/s, hand's world] for one period, cut to the scene's
  // speed limit as a controller's is; a velocity that is not finite ends the trial as
  // `invalid_output`. Nothing happens where it has ended.
  void step(const HandTwist& velocity);

  // Of the last tick, as a controller has it.
  Observation observation() const noexcept;
  // The same wrench, not relative to that at rest [N, N m, hand's world].
  HandWrench wrench() const noexcept;
  double time() const noexcept;  // [s]
  // State and forces, at the tip's scale: what no controller gets to know.
  const StepResult& result() const noexcept;
  const InsertionSummary& summary() const noexcept;
  // The scene with the parts that were drawn.
  const Scene& scene() const noexcept { return *drawn_; }
  const Scaling& scaling() const noexcept { return scaling_; }
  // How it ended; empty while it goes on.
  const std::optional<TrialResult>& ended() const noexcept { return ended_; }

 private:
  class Hand;
  struct Running;
  void expect_end();

  std::shared_ptr<const Scene> scene_, drawn_;
  Scaling scaling_;
  double entrance_ = 0;
  std::unique_ptr<Running> running_;  // null where the parts do not fit
  std::optional<TrialResult> ended_;
};

}  // namespace ferrule
