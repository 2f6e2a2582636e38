// Passivity observer and controller in the time domain (Hannaford and Ryu 2002).
//
// Observes the energy that the hand has put into what it feels, by the force f held over a period T
// and the hand's velocity v = (x_n - x_(n-1))/T over it (exact, since f did not change within):
//   E_n = E_(n-1) - T f_(n-1).v_n     [J];  f is the force on the hand: against the motion takes in
// Springs and dampers never give out more than they took: E >= 0. Where E < 0 the loop has made
// energy of its own, and damping is added to the force that is rendered next:
//   f_n -> f_n - alpha v_n,   alpha = -E_n/(T |v_n|^2),   at most `max_damping` [N s/m]
// which takes in what was given out, if the hand goes on as it did. What it does not take in stays
// in E and is asked for again.
//
// The force has to be the one that acts: where it reaches the motors d periods late, the energy
// observed is not that of the hand.
//
// The limit: alpha T/m must stay below 1 for a moved mass m, or the damping itself would throw the
// hand back. Energy that was stored honestly before hides the same amount of what is made later.
#pragma once

#include <Eigen/Core>
#include <algorithm>

namespace ferrule {

class PassivityController {
 public:
  // `period` [s], > 0; `max_damping` [N s/m], >= 0, below m/period.
  PassivityController(double period, double max_damping) noexcept
      : period_(period), max_damping_(max_damping) {}

  // Once per period: the hand's position [m] and the force [N] meant for it; returns the force to
  // render until the next call. All finite.
  Eigen::Vector3d pass(const Eigen::Vector3d& hand, const Eigen::Vector3d& force) noexcept {
    const Eigen::Vector3d move = started_ ? Eigen::Vector3d(hand - hand_) : Eigen::Vector3d::Zero();
    energy_ -= held_.dot(move);
    const Eigen::Vector3d velocity = move / period_;
    const double per_damping = period_ * velocity.squaredNorm();  // energy taken in per alpha
    damping_ = energy_ < 0 && per_damping > 0 ? std::min(-energy_ / per_damping, max_damping_) : 0;
    started_ = true;
    hand_ = hand;
    held_ = force - damping_ * velocity;
    return held_;
  }

  // The force [N] that acts instead, where something after this changed it; after `pass`.
  void acts(const Eigen::Vector3d& force) noexcept { held_ = force; }

  double energy() const noexcept { return energy_; }    // E [J]
  double damping() const noexcept { return damping_; }  // alpha of the last call [N s/m]

 private:
  double period_, max_damping_;
  bool started_ = false;
  double energy_ = 0, damping_ = 0;
  Eigen::Vector3d hand_ = Eigen::Vector3d::Zero(), held_ = Eigen::Vector3d::Zero();
};

}  // namespace ferrule
