#include "sim/scene/joint.hpp"

#include <algorithm>
#include <numbers>

#include "sim/base/elementary.hpp"

namespace ferrule {

LightAxis light_axis(const Joint& joint, const Pose& tip) noexcept {
  return {tip.segment<2>(1) + joint.offset, -tip.tail<2>()};
}

LightAxis turned(const LightAxis& axis, double angle) noexcept {
  const double c = elementary::cos(angle), s = elementary::sin(angle);
  const auto turn = [&](const Vector2d& v) {
    return Vector2d(c * v.x() - s * v.y(), s * v.x() + c * v.y());
  };
  return {turn(axis.offset), turn(axis.slope)};
}

double joint_loss_dB(const Joint& joint, const LightAxis& from, const LightAxis& into) noexcept {
  const double w = joint.partner_mode_radius.value_or(joint.mode_radius);
  const double wider = w / joint.mode_radius;
  const double spread = joint.wavelength * joint.gap /
                        (std::numbers::pi * joint.index * joint.mode_radius * joint.mode_radius);
  // 1 + A = p - i q.
  const double real = wider * wider / (1 + spread * spread), q = real * spread, p = 1 + real;
  const double square = p * p + q * q;
  const Vector2d t = from.slope - into.slope;
  const Vector2d d = from.offset - into.offset + joint.gap * from.slope;
  const double u = d.norm() / w;
  const double v = std::numbers::pi * joint.index * w * t.norm() / joint.wavelength;
  const double cross = std::numbers::pi * joint.index * d.dot(t) / joint.wavelength;
  const double nepers = 2 * u * u * (1 - p / square) + 2 * v * v * (p / square) -
                        4 * cross * (q / square) - elementary::log(4 * real / square);
  return 4.343 * std::max(0.0, nepers);
}

double pair_loss_dB(const Joint& joint, const LightAxis& one, const LightAxis& facing) noexcept {
  return joint_loss_dB(
      joint, one, {{facing.offset.x(), -facing.offset.y()}, {-facing.slope.x(), facing.slope.y()}});
}

}  // namespace ferrule
