// The usual search without knowledge, as a baseline of those with it: touches the front face again
// and again, at places along a spiral, until the end comes down in the bore.
//
//   lower    v_x = -2/3 v until the end is felt for the first time, -v/4 afterwards; it is felt
//            where f_x > F. 2 p lower than where it was felt before it is in the bore
//   lift     v_x = v, by 2 p
//   move     at v to the next place, p further along r = p phi/(2 pi)
//   insert   v_x = -v (1 - |f|/(8 F)), not backwards
//
// Not sliding: an end that sticks follows the hand by 10 um less than it moves. v is the scene's
// speed limit, F a twelfth of its force limit, p 1.41 clearances: the bore catches what comes down
// within the clearance of its axis. In the hand's world; forces are relative to that at rest at the
// start, displacements to the start.
#pragma once

#include <algorithm>
#include <numbers>

#include "controller/controller.hpp"
#include "sim/base/elementary.hpp"

namespace ferrule {

class BlindSpiral : public Controller {
 public:
  // v [m/s], F [N], p [m], all > 0.
  BlindSpiral(double speed, double force, double pitch) noexcept
      : speed_(speed), force_(force), pitch_(pitch) {}

  HandTwist command(const Observation& o) noexcept override {
    constexpr double kGoalTime = 0.01, kThere = 0.02;  // [s]; of the pitch
    HandTwist v = HandTwist::Zero();
    const double x = o.displacement[0], deep = 2 * pitch_;
    const Eigen::Vector2d left = place() - o.displacement.segment<2>(1);
    if (phase_ == Phase::lower && o.wrench[0] > force_) {
      phase_ = Phase::lift;
      felt_ = true;
      rest_ = x;
    } else if (phase_ == Phase::lower && felt_ && x < rest_ - deep) {
      phase_ = Phase::insert;
    } else if (phase_ == Phase::lift && x > rest_ + deep) {
      phase_ = Phase::move;
      turned_ += pitch_ / Eigen::Vector2d(widening() * turned_, widening()).norm();
    } else if (phase_ == Phase::move && left.norm() < kThere * pitch_) {
      phase_ = Phase::lower;
    }
    switch (phase_) {
      case Phase::lower:
        v[0] = -speed_ * (felt_ ? 0.25 : 2.0 / 3);
        break;
      case Phase::lift:
        v[0] = speed_;
        break;
      case Phase::move:
        v.segment<2>(1) = (place() - o.displacement.segment<2>(1)) / kGoalTime;
        break;
      case Phase::insert:
        v[0] = -speed_ * std::max(0.0, 1 - o.wrench.head<3>().norm() / (8 * force_));
    }
    return limit_speed(v, speed_);
  }

 private:
  enum class Phase { lower, lift, move, insert };

  double widening() const noexcept { return pitch_ / (2 * std::numbers::pi); }
  Eigen::Vector2d place() const noexcept {
    return widening() * turned_ *
           Eigen::Vector2d(elementary::cos(turned_), elementary::sin(turned_));
  }

  double speed_, force_, pitch_;
  Phase phase_ = Phase::lower;
  bool felt_ = false;
  double rest_ = 0;    // where the end was felt last [m]
  double turned_ = 0;  // phi [rad]
};

}  // namespace ferrule
