#include "sim/face_support.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/elementary.hpp"

namespace ferrule {
namespace {

// Area of the part of a disc that is more than `from` off its centre to one side.
double cap(double radius, double from) noexcept {
  const double across = std::sqrt(std::max(0.0, radius * radius - from * from));
  // The angle whose cosine is from/radius.
  const double angle = 2 * elementary::atan(across / (radius + from));
  return radius * radius * angle - from * across;
}

}  // namespace

FaceSupport::FaceSupport(double radius, double opening, const Vector2d& e) noexcept {
  const double off = e.norm(), r = radius, R = opening;
  if (!(off + r > R)) return;
  radius_ = r;
  if (off > 0) outward_ = e / off;
  least_ = -r;
  if (off >= r + R) return;  // beside the opening
  if (off + R <= r) return;  // the opening is covered: the rim supports all around
  least_ = (R * R - r * r - off * off) / (2 * off);
  // Of the lens both discs share, the first moments of its two parts cancel about the opening's
  // centre but for that of the opening's part, -off times its area.
  const double of_opening = cap(R, least_ + off);
  const double lens = std::numbers::pi * r * r - cap(r, least_) + of_opening;
  const double crescent = std::numbers::pi * r * r - lens;
  centroid_ = crescent > 0 ? std::clamp(off * of_opening / crescent, least_, r) : r;
}

FaceSupport::Rest FaceSupport::rest(const Vector2d& slope) const noexcept {
  const double r = radius_, per_tilt = r / kRestTilt;
  const Vector2d& n = outward_;
  const Vector2d across(-n.y(), n.x()), centre = centroid_ * n, to = centre + per_tilt * slope;
  const double out = to.dot(n), aside = to.dot(across), far = to.norm();
  const double half = std::sqrt(std::max(0.0, r * r - least_ * least_));
  Rest rest{0, to, per_tilt * kIdentity};
  if (far > r && r * out >= least_ * far) {
    const Vector2d u = to / far;
    rest.point = r * u;
    rest.turning = per_tilt * r / far * (kIdentity - u * u.transpose());
  } else if (out < least_ && std::abs(aside) <= half) {
    rest.point = least_ * n + aside * across;
    rest.turning = per_tilt * across * across.transpose();
  } else if (far > r || out < least_) {
    rest.point = least_ * n + std::copysign(half, aside) * across;
    rest.turning.setZero();
  }
  rest.ahead = rest.point.dot(slope) - 0.5 * (rest.point - centre).squaredNorm() / per_tilt;
  return rest;
}

}  // namespace ferrule
