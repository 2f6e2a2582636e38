// Loss of a joint between a fibre end and an ideal one (Marcuse 1977), for equal Gaussian modes.
//
//   loss = 4.343 (d/w_0)^2 + 4.343 (pi n w_0 t / lambda_0)^2   [dB]
//   d lateral offset of the axes [m], t angle between them [rad]
//   w_0 = 5.2 um mode radius, n = 1.4682, lambda_0 = 1550 nm: standard single-mode fibre.
#pragma once

#include <numbers>

namespace ferrule {

inline double joint_loss_dB(double offset, double tilt) noexcept {
  constexpr double mode_radius = 5.2e-6, index = 1.4682, wavelength = 1550e-9;
  const double d = offset / mode_radius;
  const double t = std::numbers::pi * index * mode_radius * tilt / wavelength;
  return 4.343 * (d * d + t * t);
}

}  // namespace ferrule
