#include "insertion/rendering.hpp"

#include <fmt/format.h>

#include <cmath>

#include "insertion/scene_scaling.hpp"
#include "insertion/stiffness_range.hpp"

namespace ferrule {
namespace {

// Somewhat less than x > 0, in three digits.
double rounded_down(double x) {
  double unit = 1;
  while (1000 * unit <= x) unit *= 10;
  while (100 * unit > x) unit /= 10;
  return std::floor(0.999 * x / unit) * unit;
}

// Why the device does not render the felt stiffness K and damping B; empty where it does.
std::vector<std::string> refusals(const DeviceProfile& device, double K, double B) {
  std::vector<std::string> reasons;
  const double needed = damping_needed(device, K, B);
  if (!(device.damping > needed) && needed > 0)
    reasons.push_back(fmt::format("it needs more than {:.4g} N s/m of damping and has {:.4g}",
                                  needed, device.damping));
  if (K > resting_stiffness(device))
    reasons.push_back(
        fmt::format("its position steps of {:g} um with {:g} N of friction come to rest only up to "
                    "{:.4g} N/m",
                    1e6 * device.resolution, device.coulomb, resting_stiffness(device)));
  if (K > device.max_stiffness)
    reasons.push_back(fmt::format("its stiffest wall has {:.4g} N/m", device.max_stiffness));
  return reasons;
}

}  // namespace

std::string Rendering::set() const {
  if (!std::isfinite(largest_hand_force) || !(largest_hand_force > 0)) return "";
  return fmt::format("--set scaling.hand_force_N={:g}", largest_hand_force);
}

Rendering rendering(const Scene& scene, const DeviceProfile& device,
                    const std::function<bool(std::size_t done, std::size_t all)>& go_on) {
  const Scaling scaling = scene_scaling(scene);
  Rendering r;
  r.tip = insertion_stiffness(scene, device.period, go_on);
  r.magnified = scaling.force / scaling.motion;
  r.stiffness = r.magnified * r.tip.largest;
  r.damping = r.magnified * r.tip.damping;
  r.reasons = refusals(device, r.stiffness, r.damping);
  const double largest =
      largest_force_scaling(device, scaling.motion, r.tip.largest, r.tip.damping) *
      scene.scaling.tip_force;
  r.largest_hand_force = std::isfinite(largest) && largest > 0 ? rounded_down(largest) : largest;
  return r;
}

// With x = gain times the way of the grip, and the same force: m x''/gain, b x'/gain, and so on.
DeviceProfile at_gain(DeviceProfile device, double gain) noexcept {
  device.mass /= gain;
  device.damping /= gain;
  device.resolution *= gain;
  device.max_stiffness /= gain;
  return device;
}

}  // namespace ferrule
