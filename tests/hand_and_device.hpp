// A hand on a force feedback device, in one direction, for tests: a mass with viscous damping and
// Coulomb friction, pushed by a constant force of the hand and by a force that the loop holds over
// every period; the position is measured in steps, the force comes whole periods late.
#pragma once

#include <cmath>
#include <deque>

#include "haptic/device_profile.hpp"

namespace ferrule::testing {

class HandAndDevice {
 public:
  double x = 0, v = 0;    // [m], [m/s]
  double hand_force = 0;  // [N]

  explicit HandAndDevice(const DeviceProfile& profile)
      : profile_(profile), late_(static_cast<std::size_t>(profile.delay_periods), 0.0) {}

  // Position as the loop sees it [m].
  double measured() const {
    return profile_.resolution > 0 ? profile_.resolution * std::round(x / profile_.resolution) : x;
  }

  // One period in which the loop asks for `force` [N]. Exact where there is no Coulomb friction.
  void advance(double force) {
    late_.push_back(force);
    const double applied = late_.front() + hand_force;
    late_.pop_front();
    const int parts = profile_.coulomb > 0 ? 50 : 1;
    for (int i = 0; i < parts; ++i) part(applied, profile_.period / parts);
  }

 private:
  void part(double force, double dt) {
    const double m = profile_.mass, b = profile_.damping, f_c = profile_.coulomb;
    const double direction = v != 0 ? v : force;
    if (v == 0 && std::abs(force) <= f_c) return;
    const double f = force - (direction > 0 ? f_c : -f_c);
    const double decay = -std::expm1(-b * dt / m);
    const double goal = b > 0 ? f / b : 0;
    const double after = b > 0 ? v + (goal - v) * decay : v + f * dt / m;
    x += b > 0 ? goal * dt + (v - goal) * (m / b) * decay : 0.5 * (v + after) * dt;
    v = f_c > 0 && v * after < 0 ? 0 : after;
  }

  DeviceProfile profile_;
  std::deque<double> late_;
};

}  // namespace ferrule::testing
