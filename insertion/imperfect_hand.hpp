// A hand that does not move the holder quite as it means to: gain, delay, smoothing, dead zone
// (HandErrors of sim/scene/scene.hpp).
//
// The hand means to move by u_n in tick n [m, rad; hand's world]. The holder moves by
//   w_n = g s_n,  s_n = s_n-1 + (1 - exp(-T/tau)) (z_n-m - s_n-1),
//   z_n = u_n, 0 in the directions sideways and along where they are slower than the dead zone,
// with m the delay in whole ticks, T the tick and tau the time of smoothing. Turns have no dead
// zone.
#pragma once

#include <vector>

#include "haptic/scaling.hpp"
#include "sim/scene/scene.hpp"

namespace ferrule {

class ImperfectHand {
 public:
  // `period` T [s].
  ImperfectHand(const HandErrors& errors, const Scaling& scaling, double period);

  // The holder's pose where the hand means to be at `pose`, one tick after the call before; the
  // first is where both begin. Without errors `pose`, bit for bit.
  HandPose holder(const HandPose& pose) noexcept;

 private:
  bool perfect_;
  double gain_, followed_, slowest_;  // followed: 1 - exp(-T/tau); slowest: motion in a tick [m]
  std::vector<HandTwist> underway_;   // motions that are not at the holder yet, as a ring
  std::size_t next_ = 0;
  bool begun_ = false;
  HandPose meant_ = HandPose::Zero(), holder_ = HandPose::Zero();
  HandTwist smooth_ = HandTwist::Zero();
};

}  // namespace ferrule
