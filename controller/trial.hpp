// One trial: a controller inserts a fibre by itself, at the tip's scale.
#pragma once

#include "controller/controller.hpp"
#include "insertion/loop.hpp"
#include "sim/base/control_period.hpp"

namespace ferrule {

struct TrialResult {
  Outcome outcome;
  InsertionSummary summary;
  double loss_dB;  // of its joint with an ideal partner; NaN unless inserted or high_loss
  std::optional<Supervision> supervision;  // empty for a controller without supervisor
  std::string why{};                       // the controller failed; empty where it did not
  LightAxis light{};                       // where the light leaves its end
};

// Of an insertion in `scene` that ended so, with the joint that follows.
TrialResult trial_result(const Scene& scene, Outcome outcome,
                         const InsertionSummary& summary) noexcept;

// An insertion by the controller's hand, until it succeeds or fails. The controller observes what
// the scene's force sensor reads, scaled up by that of the scene, and its velocity is scaled down;
// control and simulation share one period [s]. Every tick is shown to `on_tick`, if any. `stop`
// ends it as `interrupted` (insertion/loop.hpp).
TrialResult run_trial(const TrialSetup& trial, Controller& controller,
                      double period = kControlPeriod, const OnTick& on_tick = {},
                      const std::function<bool()>& stop = {});

// Trial `trial` of a campaign under `seed`, in which that is drawn; `infeasible` where the parts
// that are cannot be together.
TrialResult run_trial(const Scene& scene, Controller& controller, std::uint64_t seed,
                      std::uint64_t trial, double period = kControlPeriod,
                      const OnTick& on_tick = {}, const std::function<bool()>& stop = {},
                      const std::string& redrawn = "");

// A controller as a device: the hand of a trial, and of a recording of it like that of a person.
class ControllerHand : public Device {
 public:
  // `speed` limits it [m/s, hand's world]; it is finished once it and the holder, which may be late
  // or move less, are past `end_depth` [m, hand's world], when its controller is done, and when its
  // supervisor gives up. Depths are from where it takes the entrance to be (x [m, hand's world]).
  // `force_limit` is told to the controller.
  ControllerHand(Controller& controller, const HandPose& start, double speed, double end_depth,
                 double entrance = 0, double force_limit = std::numeric_limits<double>::infinity());
  HandSample read(double t) override;
  void render(const HandWrench& wrench) override;
  void holder_at(const HandPose& holder) override { holder_ = holder; }

 private:
  Controller& controller_;
  HandPose start_, pose_, holder_;
  HandTwist velocity_ = HandTwist::Zero();
  double speed_, end_depth_, entrance_, force_limit_, time_ = 0;
};

// The hand of a recording: until a tenth past the success depth.
ControllerHand recorded_hand(const TrialSetup& trial, Controller& controller);

}  // namespace ferrule
