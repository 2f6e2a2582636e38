// The loop between hand and fibre: a hand goes in, ticks come out.
//
// The hand is a Device (haptic/device.hpp): a person at one, a simulated operator, a controller, a
// recording. Tick n, at time t_n = n T:
//   read     the hand is at a pose, to which it has moved the fibre's holder, but for the errors of
//            the scene's hand (insertion/imperfect_hand.hpp)
//   step     the simulator steps to it, which gives the state and the forces at t_n
//   render   the hand feels the holder's wrench, as the force sensor reads it, relative to that at
//            rest at t_0
//   watch    has the insertion ended? (insertion/watch.hpp)
//   answer   the hand moves on: `command` is its velocity over [t_n, t_n+1)
// A tick pairs a force with the velocity that answers it. A listener makes of it what he needs: a
// row, a statistic, a frame.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "haptic/device.hpp"
#include "haptic/force_feedback.hpp"
#include "insertion/sensed_wrench.hpp"
#include "insertion/trial_setup.hpp"
#include "insertion/watch.hpp"
#include "sim/base/control_period.hpp"

namespace ferrule {

// Everything at t_n, in the hand's world but for `result`. Lives as long as the call it is shown
// in.
struct Tick {
  double time;                 // t_n [s]
  const HandSample& sample;    // as the device gave it
  const HandPose& hand;        // pose of the fibre's holder: the sample's, or what its errors or a
                               // coupling made of it
  const HandTwist& velocity;   // of it over [t_n-1, t_n); 0 in the first tick [m/s, rad/s]
  const HandTwist& command;    // of it over [t_n, t_n+1) [m/s, rad/s]
  const StepResult& result;    // state at t_n, at the tip's scale
  const Breakdown& forces;     // on the fibre there
  const HandWrench& wrench;    // at the holder, as the sensor reads it [N, N m]
  const HandWrench& relative;  // to that of the first tick, at rest [N, N m]
};

struct LoopSettings {
  double period = kControlPeriod;  // T [s], > 0
  // Whether the hand goes on after success until it is finished, as a simulated operator does; or
  // success ends the insertion, as in a trial.
  bool past_success = false;
  // The hand is that of a recording, which has the errors of the scene's hand in it.
  bool recorded = false;
  // Where a person feels the fibre, and holds it, by way of that: what it cannot trust ends the
  // insertion as `interrupted`, with no force and after the ticks before.
  ForceFeedback* feedback = nullptr;
  // Asked now and then; where it says so, the insertion ends as `interrupted`.
  std::function<bool()> stop{};
};

struct InsertionEnd {
  Outcome outcome;
  InsertionSummary summary;
  std::string why;    // the operator gave up, or what ended it; may be empty
  bool lost = false;  // the device is gone
  // What else ended a hand that went on past success: a failure of the fibre there, a device that
  // was lost. The outcome is `inserted` all the same.
  std::optional<Outcome> afterwards{};
};

// False ends the insertion as `interrupted`.
using OnTick = std::function<bool(const Tick&)>;

// One insertion, tick by tick, for who answers in between (a program of somebody
// else's that steps it). All that it is given must outlive it.
class Insertion {
 public:
  Insertion(const TrialSetup& trial, Device& hand, const LoopSettings& settings);
  ~Insertion();
  Insertion(const Insertion&) = delete;
  Insertion& operator=(const Insertion&) = delete;

  // In turns, until one of them says why it ended:
  // steps to where the hand is and lets it feel that,
  const std::optional<InsertionEnd>& feel();
  // lets it move on, and shows the tick. After what feel() saw to end it, too.
  const std::optional<InsertionEnd>& answer(const OnTick& on_tick = {});

  // What the last feel() came to.
  double time() const noexcept;  // t_n [s]
  const StepResult& result() const noexcept;
  const SensedWrench& sensed() const noexcept;
  // Whether that ends it: answer() will.
  bool over() const noexcept;
  const std::optional<InsertionEnd>& end() const noexcept;
  const InsertionSummary& summary() const noexcept;

 private:
  struct Held;
  class Grip;
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

// Runs one insertion by a hand that begins at trial.hand() until it fails, succeeds (see
// `past_success`) or the hand is finished, for the scene's longest trial at most, and shows every
// tick to `on_tick`, if any; one at least. The outcome is the first that the watch sees, and where
// there is none
//   stopped_short    the hand finished before the success depth
//   gave_up          the same, and says that this was giving up
//   interrupted      `on_tick` or `stop` ended it, the device was lost, or `feedback` did not trust it
//   invalid_output   the hand's pose is not a finite number: no tick any more
// Where the fibre was in before, each of these leaves it `inserted`.
// Does not allocate while it runs, after its begin. Throws what `hand` and `on_tick` throw.
InsertionEnd run_insertion(const TrialSetup& trial, Device& hand, const LoopSettings& settings,
                           const OnTick& on_tick = {});

}  // namespace ferrule
