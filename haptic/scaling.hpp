// Scaling between the hand's world and the tip's, equations (12) to (15) of the paper:
//
//   X_s = alpha_x X_m          positions, lengths, velocities       (12) (13)
//   F_s = alpha_f F_m          forces
//   alpha_x = (x_s range) / (x_m range),  alpha_f = (f_s range) / (f_m range)   (14) (15)
//   moments scale by alpha_f alpha_x; angles and time do not scale.
//
// The same functions serve a person's hand (tip forces up, hand motion down) and a controller that
// was learned in the hand's world (the same way round: it too feels scaled forces and commands
// scaled motion). Names say which world a quantity belongs to: _hand or _tip.
#pragma once

#include <Eigen/Core>

namespace ferrule {

// (x, y, z [m], tilt_y, tilt_z [rad]) or its rate, in the hand's world.
using HandPose = Eigen::Matrix<double, 5, 1>;
using HandTwist = Eigen::Matrix<double, 5, 1>;
// (F_x, F_y, F_z [N], M_y, M_z [N m]) felt by the hand.
using HandWrench = Eigen::Matrix<double, 5, 1>;

struct Scaling {
  double motion;  // alpha_x [-], > 0
  double force;   // alpha_f [-], > 0

  bool operator==(const Scaling&) const noexcept = default;

  // From ranges [m], [N], all > 0.
  static Scaling from_ranges(double hand_range, double tip_range, double hand_force,
                             double tip_force) noexcept {
    return {hand_range / tip_range, hand_force / tip_force};
  }

  HandPose motion_to_hand(const Eigen::Matrix<double, 5, 1>& tip) const noexcept {
    HandPose hand = tip;
    hand.head<3>() *= motion;
    return hand;
  }
  Eigen::Matrix<double, 5, 1> motion_to_tip(const HandPose& hand) const noexcept {
    Eigen::Matrix<double, 5, 1> tip = hand;
    tip.head<3>() /= motion;
    return tip;
  }
  HandWrench wrench_to_hand(const Eigen::Matrix<double, 5, 1>& tip) const noexcept {
    HandWrench hand = tip * force;
    hand.tail<2>() *= motion;
    return hand;
  }
};

}  // namespace ferrule
