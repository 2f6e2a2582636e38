// The last thing between the computed force and the motors.
//
//   waiting   no force, until |F| < quiet_force for quiet_periods in a row
//   ramping   F times a factor that rises from 0 to 1 over `ramp`
//   engaged   F
// In each, |F| is held at the device's limit, the moment reduced by the same factor. Something that
// is not finite, a hand that has moved faster than a hand moves, or a sample older than 1.5 periods
// makes the force zero in the same call, and the guard waits again. A hand sample that stays away
// therefore ends the force within two periods; `why` says which it was.
//
// Many devices report only every few periods, and only when they move: how far the hand may have
// moved is counted from its last move, over `report_period` at most.
//
// The weight of the fibre is to be left out of F: with it a guard may wait for ever.
#pragma once

#include <algorithm>
#include <cmath>

#include "haptic/scaling.hpp"
#include "sim/base/control_period.hpp"

namespace ferrule {

struct GuardSettings {
  double max_force;                // of the device [N], > 0
  double period = kControlPeriod;  // of the loop [s], > 0
  double quiet_force = 0.2;        // [N]
  int quiet_periods = 5;
  double ramp = 2;            // [s], >= 0
  double max_hand_speed = 2;  // [m/s]: above it the hand has jumped
  double max_turn_rate = 20;  // [rad/s]: the same of its tilts
  double report_period = 0;   // longest time between reports of a moving hand [s]; 0: `period`
};

class ForceGuard {
 public:
  enum class Stage { waiting, ramping, engaged };

  explicit ForceGuard(const GuardSettings& settings) noexcept : settings_(settings) {}

  // What is wrong with a hand pose taken at `sampled_at` [s], at time `now` [s]; null: nothing.
  const char* doubt(double now, double sampled_at, const HandPose& hand) const noexcept {
    if (!hand.allFinite()) return "the hand's position is not a finite number";
    if (!(now - sampled_at <= 1.5 * settings_.period)) return "the hand's position is too old";
    const double most = std::max(settings_.period, settings_.report_period);
    const double since = std::clamp(now - moved_at_, settings_.period, most);
    const HandPose moved = seen_ ? HandPose(hand - hand_) : HandPose(HandPose::Zero());
    const bool jumped = !(moved.head<3>().norm() <= settings_.max_hand_speed * since &&
                          moved.tail<2>().norm() <= settings_.max_turn_rate * since);
    return jumped ? "the hand jumped" : nullptr;
  }

  // Once per period at time `now` [s]: the newest hand pose, taken at `sampled_at` [s], and the
  // wrench that is meant for the hand. Returns the wrench to render.
  HandWrench pass(double now, double sampled_at, const HandPose& hand,
                  const HandWrench& wanted) noexcept {
    why_ = doubt(now, sampled_at, hand);
    if (!why_ && !(wanted.allFinite() && std::isfinite(wanted.head<3>().norm())))
      why_ = "the force is not a finite number";
    if (why_) {
      seen_ = false;
      stage_ = Stage::waiting;
      quiet_ = 0;
      return HandWrench::Zero();
    }
    if (!seen_ || hand != hand_) moved_at_ = now;
    seen_ = true;
    hand_ = hand;
    const double force = wanted.head<3>().norm();
    if (stage_ == Stage::waiting) {
      quiet_ = force < settings_.quiet_force ? quiet_ + 1 : 0;
      if (quiet_ < settings_.quiet_periods) return HandWrench::Zero();
      stage_ = Stage::ramping;
      ramp_began_ = now;
    }
    double factor = 1;
    if (stage_ == Stage::ramping) {
      factor = settings_.ramp > 0 ? std::clamp((now - ramp_began_) / settings_.ramp, 0.0, 1.0) : 1;
      if (factor == 1) stage_ = Stage::engaged;
    }
    if (factor * force > settings_.max_force) factor = settings_.max_force / force;
    return factor * wanted;
  }

  // The device has let its force go by itself at time `now` [s]: what there was ramps up again.
  void ramp_again(double now) noexcept {
    if (stage_ == Stage::waiting) return;
    stage_ = Stage::ramping;
    ramp_began_ = now;
  }

  Stage stage() const noexcept { return stage_; }
  // What was wrong in the last call; null: nothing.
  const char* why() const noexcept { return why_; }

 private:
  GuardSettings settings_;
  Stage stage_ = Stage::waiting;
  int quiet_ = 0;
  double ramp_began_ = 0;
  bool seen_ = false;
  HandPose hand_ = HandPose::Zero();
  double moved_at_ = 0;  // [s]
  const char* why_ = nullptr;
};

}  // namespace ferrule
