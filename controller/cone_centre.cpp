#include "controller/cone_centre.hpp"

#include <algorithm>
#include <cmath>

namespace ferrule {

using Eigen::Vector2d;

Vector2d centre_of_circle(const Vector2d& first, const Vector2d& second, double radius) noexcept {
  const Vector2d apart = second - first;
  Vector2d middle = first + 0.5 * apart;
  if (apart.isZero(0)) return middle;
  const double off = std::sqrt(std::max(0.0, radius * radius - 0.25 * apart.squaredNorm()));
  return middle + off * Vector2d(-apart.y(), apart.x()).normalized();
}

void ConeCentre::arrived(const Vector2d& place) noexcept {
  const Vector2d y = Vector2d::UnitX(), z = Vector2d::UnitY();
  if (next_.until_felt) touched_ = place;
  if (++step_ == 1) {
    first_ = place;
    next_ = fine_ ? SidewaysMove{true, -y} : SidewaysMove{false, place - play_ * y};
  } else if (fine_ && step_ == 2) {
    play_ = 0.5 * (first_ - place).norm();
    next_ = {false, 0.5 * (first_ + place)};
  } else if (step_ == last() - 2) {
    next_ = {true, z};
  } else if (step_ == last() - 1) {
    next_ = {false, fine_ ? Vector2d(place - play_ * z) : centre_of_circle(first_, place, play_)};
  }
}

}  // namespace ferrule
