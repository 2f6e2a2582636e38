// A virtual coupling (Colgate, Stanley and Brown 1995): a spring and a damper between the hand x
// and the fibre's holder h, both positions in the hand's world.
//
// The holder has no mass, so what the coupling pulls is what the fibre resists with, F(h):
//   K_c (x - h) + B_c (v_x - v_h) + F(h) = 0,
// and the hand feels F too, never stiffer than K_c. Stepped linearly implicit, with the stiffness
// K_e of the fibre at the last holder position: F(h') = F(h) - K_e (h' - h), so that
//   (B_c/T + K_c + K_e)(h' - h) = K_c (x' - h) + B_c/T (x' - x) + F(h).
// With K_e as it is the holder neither overshoots a stiff contact nor lags behind in free air. In
// series with the scene's own holder the coupling makes it softer; that is its purpose.
#pragma once

#include <Eigen/Eigenvalues>

#include "haptic/stability.hpp"

namespace ferrule {

class VirtualCoupling {
 public:
  // `period` [s], > 0. Holder and hand begin at `hand` [m].
  VirtualCoupling(const Coupling& coupling, double period, const Eigen::Vector3d& hand) noexcept
      : stiffness_(coupling.stiffness),
        per_move_(coupling.damping / period),
        hand_(hand),
        holder_(hand) {}

  // Once per period: the hand's new position [m]; force [N] and stiffness -dF/dh [N/m, symmetric]
  // of the fibre at the holder's last position. Returns the holder's new position [m]. Attraction
  // (negative eigenvalues of the stiffness) is met without foresight.
  Eigen::Vector3d move(const Eigen::Vector3d& hand, const Eigen::Vector3d& force,
                       const Eigen::Matrix3d& stiffness) noexcept {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> modes(stiffness);
    const Eigen::Vector3d resists =
        (modes.eigenvalues().cwiseMax(0).array() + stiffness_ + per_move_).matrix();
    const Eigen::Vector3d pull = stiffness_ * (hand - holder_) + per_move_ * (hand - hand_) + force;
    const Eigen::Vector3d along = modes.eigenvectors().transpose() * pull;
    const Eigen::Vector3d moved = modes.eigenvectors() * along.cwiseQuotient(resists);
    const Eigen::Vector3d slip = moved - (hand - hand_);
    holder_ += moved;
    hand_ = hand;
    force_ = stiffness_ * (holder_ - hand_) + per_move_ * slip;
    return holder_;
  }

  // On the hand, after the last move [N].
  const Eigen::Vector3d& force() const noexcept { return force_; }

 private:
  double stiffness_, per_move_;  // K_c and B_c/T [N/m]
  Eigen::Vector3d hand_, holder_, force_ = Eigen::Vector3d::Zero();
};

}  // namespace ferrule
