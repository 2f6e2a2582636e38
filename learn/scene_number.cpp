#include "learn/scene_number.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim/base/elementary.hpp"
#include "sim/scene/scene_keys.hpp"

namespace ferrule {
SceneNumber::SceneNumber(const Scene& scene, const std::string& key) : key_(key) {
  VariableScene varied(scene);
  const std::optional<double> number = varied.number(key);
  if (!number)
    throw BadInput(
        fmt::format("parameter {}: there is no such number in the scene {}", key, scene.name));
  start_ = *number;
  const auto allowed = [&](double value) {
    varied.set(key, value);
    return varied.consistent();
  };
  below_ = edge(allowed, -1);
  above_ = edge(allowed, 1);
  const double room = 1e-9 * std::max(std::abs(start_), 1e-300);
  if (find_scene_key(key)->rule.whole || !(start_ - below_ > room) || !(above_ - start_ > room))
    throw BadInput(fmt::format("parameter {}: cannot be varied from {}", key, start_));
}

double SceneNumber::value(double x) const {
  const bool low = std::isfinite(below_), high = std::isfinite(above_);
  if (low && high) {
    const double ratio = (start_ - below_) / (above_ - start_) * elementary::exp(x);
    return (below_ + above_ * ratio) / (1 + ratio);
  }
  if (low) return below_ + (start_ - below_) * elementary::exp(x);
  if (high) return above_ - (above_ - start_) * elementary::exp(-x);
  return start_ + (start_ != 0 ? std::abs(start_) : 1) * x;
}

// Where values from the start on in direction `sign` cease to be allowed; infinite if not within a
// factor of a thousand, and 0 if not that near to it: farther than a parameter is moved.
double SceneNumber::edge(const std::function<bool(double)>& allowed, double sign) const {
  const double size = std::max(std::abs(start_), 1e-3);
  if (sign * start_ < 0 && allowed(1e-3 * start_) && !allowed(-1e-3 * start_)) return 0;
  double inside = start_, outside = start_ + sign * 1e3 * size;
  if (allowed(outside)) return sign * INFINITY;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (inside + outside);
    (allowed(middle) ? inside : outside) = middle;
  }
  return inside;
}

}  // namespace ferrule
