#include "insertion/imperfect_hand.hpp"

#include <cmath>

#include "sim/base/elementary.hpp"

namespace ferrule {

ImperfectHand::ImperfectHand(const HandErrors& errors, const Scaling& scaling, double period)
    : perfect_(errors.none()),
      gain_(errors.gain),
      followed_(errors.smoothing > 0 ? -elementary::expm1(-period / errors.smoothing) : 1),
      slowest_(scaling.motion * errors.dead_zone * period),
      underway_(static_cast<std::size_t>(std::lround(errors.delay / period)), HandTwist::Zero()) {}

HandPose ImperfectHand::holder(const HandPose& pose) noexcept {
  if (perfect_) return pose;
  if (!begun_) meant_ = holder_ = pose;
  begun_ = true;
  HandTwist motion = pose - meant_;
  meant_ = pose;
  if (motion.head<3>().norm() < slowest_) motion.head<3>().setZero();
  if (!underway_.empty()) {
    std::swap(motion, underway_[next_]);
    next_ = (next_ + 1) % underway_.size();
  }
  smooth_ += followed_ * (motion - smooth_);
  holder_ += gain_ * smooth_;
  return holder_;
}

}  // namespace ferrule
