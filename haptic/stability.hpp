// Can a device render a stiffness without adding energy of its own?
//
// A sampled spring K with damping B pushes with the force of the last sample for a whole period T,
// d periods late: too weakly on the way in, too strongly on the way out. The device's damping b has
// to take up the energy that this makes.
//
// Colgate and Schenkel (1997): with H(z) = (K + B (1 - 1/z)/T) z^-d the whole is passive exactly if
//   b > T/2  max over w of  Re[(1 - e^-iwT) H(e^iwT)] / (1 - cos wT).
// The spring's part is K times sin((2d + 1) wT/2)/sin(wT/2), at most K (2d + 1); the damper's is
// -2 B/T cos((d + 1) wT), at most 2 |B|/T. So it is enough, and for d = 0 necessary, that
//   b > K T (2d + 1)/2 + |B|.
// Attraction (K < 0) asks for nothing: it is for the hand to hold.
//
// Position quantised in steps Delta with Coulomb friction f_c (Abbott and Okamura 2005; Diolaiti et
// al. 2006): forces come in steps K Delta, and a hand that pushes with half a step in between finds
// rest exactly if K Delta/2 <= f_c:
//   K <= 2 f_c/Delta.
// All in the hand's world: a tip stiffness K feels like alpha_f/alpha_x K (haptic/scaling.hpp).
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "haptic/device_profile.hpp"
#include "haptic/scaling.hpp"

namespace ferrule {

// What a spring K [N/m] with a damper B [N s/m] has to be rendered with [N s/m].
inline double damping_needed(const DeviceProfile& device, double K, double B = 0) noexcept {
  return std::max(0.0, K) * device.period * (device.delay_periods + 0.5) + std::abs(B);
}

// The stiffest spring that is passive beside a damper B [N/m]; 0 where B is already too much.
inline double passive_stiffness(const DeviceProfile& device, double B = 0) noexcept {
  return std::max(0.0, device.damping - std::abs(B)) /
         (device.period * (device.delay_periods + 0.5));
}

// The stiffest spring that comes to rest in spite of the quantised position [N/m].
inline double resting_stiffness(const DeviceProfile& device) noexcept {
  return device.resolution > 0 ? 2 * device.coulomb / device.resolution
                               : std::numeric_limits<double>::infinity();
}

// The stiffest spring that the device renders stably [N/m]: both bounds, and what its maker says.
inline double stable_stiffness(const DeviceProfile& device, double B = 0) noexcept {
  return std::min({passive_stiffness(device, B), resting_stiffness(device), device.max_stiffness});
}

// A spring and a damper between the hand and what holds the fibre (haptic/virtual_coupling.hpp).
// What it couples to feels no stiffer than `stiffness`, so that it is stable with every scene.
struct Coupling {
  double stiffness;  // [N/m], > 0
  double damping;    // [N s/m], >= 0
};

// The stiffest coupling that leaves the device some damping: half of b for the spring, 0.4 of b for
// the coupling's damper, a tenth to spare.
inline Coupling stable_coupling(const DeviceProfile& device) noexcept {
  return {
      std::min({0.5 * passive_stiffness(device), resting_stiffness(device), device.max_stiffness}),
      0.4 * device.damping};
}

// The largest force scaling alpha_f [-] that is stable: for a tip of stiffness K [N/m] and damping
// B [N s/m], both bounds in the hand's world at once. Infinite where there is nothing to feel.
inline double largest_force_scaling(const DeviceProfile& device, double motion_scaling, double K,
                                    double B) noexcept {
  const double infinity = std::numeric_limits<double>::infinity();
  const double needed = damping_needed(device, K, B);
  const double passive = needed > 0 ? device.damping / needed : infinity;
  const double stiff =
      K > 0 ? std::min(resting_stiffness(device), device.max_stiffness) / K : infinity;
  return motion_scaling * std::min(passive, stiff);
}

}  // namespace ferrule
