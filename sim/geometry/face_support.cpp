#include "sim/geometry/face_support.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/base/elementary.hpp"

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
  off_ = off;
  if (off > 0) outward_ = e / off;
  least_ = -r;
  if (off >= r + R) return;  // beside the opening
  if (off + R <= r) {        // the opening is covered: the rim supports all around
    centroid_by_off_ = R * R / (r * r - R * R);
    centroid_ = centroid_by_off_ * off;
    return;
  }
  least_ = (R * R - r * r - off * off) / (2 * off);
  least_by_off_ = -least_ / off - 1;
  // Of the lens both discs share, the first moments of its two parts cancel about the opening's
  // centre but for that of the opening's part, -off times its area.
  const double of_opening = cap(R, least_ + off);
  const double lens = std::numbers::pi * r * r - cap(r, least_) + of_opening;
  const double crescent = std::numbers::pi * r * r - lens;
  centroid_ = crescent > 0 ? off * of_opening / crescent : r;
  const double chord = 2 * std::sqrt(std::max(0.0, r * r - least_ * least_));
  if (crescent > 0 && centroid_ > least_ && centroid_ < r)
    centroid_by_off_ = (of_opening - chord * (off * (least_by_off_ + 1) + centroid_)) / crescent;
  else
    centroid_by_off_ = least_by_off_;
  centroid_ = std::clamp(centroid_, least_, r);
}

FaceSupport::Rest FaceSupport::rest(const Vector2d& slope) const noexcept {
  const double r = radius_, per_tilt = r / kRestTilt;
  const Vector2d& n = outward_;
  const Vector2d across(-n.y(), n.x()), centre = centroid_ * n, to = centre + per_tilt * slope;
  const double out = to.dot(n), aside = to.dot(across), far = to.norm();
  const double half = std::sqrt(std::max(0.0, r * r - least_ * least_));
  Rest rest{0, to, Vector2d::Zero(), per_tilt * kIdentity};
  Vector2d moves = Vector2d::Zero();  // what bounds p, with |e|
  if (far > r && r * out >= least_ * far) {
    const Vector2d u = to / far;
    rest.point = r * u;
    rest.turning = per_tilt * r / far * (kIdentity - u * u.transpose());
  } else if (out < least_ && std::abs(aside) <= half) {
    rest.point = least_ * n + aside * across;
    rest.turning = per_tilt * across * across.transpose();
    moves = least_by_off_ * n;
  } else if (far > r || out < least_) {
    const double to_side = std::copysign(1.0, aside);
    rest.point = least_ * n + to_side * half * across;
    rest.turning.setZero();
    if (half > 0) moves = least_by_off_ * (n - to_side * least_ / half * across);
  }
  const Vector2d pull = (rest.point - centre) / per_tilt;
  rest.ahead = rest.point.dot(slope) - 0.5 * pull.dot(rest.point - centre);
  const double by_off = moves.dot(slope - pull) + centroid_by_off_ * pull.dot(n);
  // As it turns about the opening's axis, all turns with it.
  const double by_angle =
      n.dot(rest.point) * across.dot(slope) - across.dot(rest.point) * n.dot(slope);
  rest.by_e = by_off * n;
  if (off_ > 0) rest.by_e += by_angle / off_ * across;
  return rest;
}

}  // namespace ferrule
