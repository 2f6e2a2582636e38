// Loss of a joint between two fibres whose ends face each other, by the overlap of their Gaussian
// modes (Marcuse 1977; Joyce and DeLoach 1984).
//
//   loss = 4.343 (2 u^2 Re[A/(1+A)] + 2 v^2 Re[1/(1+A)] - 4 u.v Im[1/(1+A)]
//                 - ln(4 Re A/|1+A|^2))                                       [dB]
//   A = (w_2/w_1)^2/(1 + i z),  z = lambda_0 g/(pi n w_1^2)
//   u = (d_1 + g t_1 - d_2)/w_2,  v = pi n w_2 (t_1 - t_2)/lambda_0
//   d_1, d_2 offsets of the axes that the light leaves and enters, where it does [m], t_1, t_2
//   their slopes along the way of the light [rad], g gap between the ends [m], w_1, w_2 mode radii
//   (where the field is 1/e of that on the axis) [m], lambda_0 wavelength in vacuum [m],
//   n refractive index of the fibres and of what fills the gap.
//
// All of them act at once; the light may go either way. Equal modes without a gap (A = 1) lose
// 4.343 (d/w)^2 + 4.343 (pi n w t/lambda_0)^2. 4.343 is 10/ln 10 as Marcuse rounds it: the coupling
// efficiency is exp(-loss/4.343). It holds for small slopes, and modes wider than the wavelength.
// Nothing is reflected: the ends touch, or what is between them has the fibres' index.
#pragma once

#include <optional>

#include "sim/geometry/pose.hpp"

namespace ferrule {

struct Joint {
  double wavelength = 1550e-9;  // in vacuum [m], > 0
  double index = 1.4682;        // refractive, >= 1
  double mode_radius = 5.2e-6;  // half of the mode field diameter [m], > 0
  // That of the fibre on the other side [m], > 0; empty: the same.
  std::optional<double> partner_mode_radius;
  double gap = 0;  // between the ends [m], >= 0
  // Standard deviations, in y and in z, of the core's axis from that of its fibre and of the bore's
  // axis from that of its ferrule [m], >= 0.
  double core_sd = 0, bore_sd = 0;
  // Of the core from the ferrule's axis, were the fibre in the middle of the bore [m]: what these
  // came to in this trial.
  Vector2d offset = Vector2d::Zero();
};

// The axis along which light leaves an end: from the ferrule's axis [m], and its slope along the
// way out [rad].
struct LightAxis {
  Vector2d offset = Vector2d::Zero(), slope = Vector2d::Zero();
};

// Of a fibre whose end has that pose in the bore. (The light goes on along the insertion.)
LightAxis light_axis(const Joint& joint, const Pose& tip) noexcept;

// As a connector that is turned by `angle` [rad] about the ferrule's axis has it.
LightAxis turned(const LightAxis& axis, double angle) noexcept;

// Of light from the fibre at `from` into the partner, whose axis in the same frame and the same
// direction is `into`: the ideal one, unless given.
double joint_loss_dB(const Joint& joint, const LightAxis& from,
                     const LightAxis& into = {}) noexcept;

// Of light from one connector into another one that faces it, both as seen from their own side:
// the second is turned over about y, so that its offset along z and its slope along y change signs.
double pair_loss_dB(const Joint& joint, const LightAxis& one, const LightAxis& facing) noexcept;

}  // namespace ferrule
