#include "controller/search_law.hpp"

#include <algorithm>
#include <cmath>

namespace ferrule {
namespace {

using Eigen::Vector2d;

constexpr double kNoises = 6;        // standard deviations of the sensor that it does not reach
constexpr double kSmoothNoises = 2;  // the same of the smoothed wrench
constexpr double kSmoothing = 0.05;  // share of a new reading in that
constexpr double kSettling = 0.4;    // of the time it rests, before the force counts
constexpr double kLeft = 0.4;        // of the force, where it has given way
constexpr double kReleasing = 0.25;  // of the touching speed
constexpr double kClear = 0.25;      // of the lift: above what can be in the way
constexpr double kGoalTime = 0.01;   // with which it settles at a place [s]
constexpr double kTiltTime = 0.1;    // and at a tilt, inserting [s]
constexpr double kThere = 1e-3;      // of r: that near a place it is there
constexpr double kTilted = 0.01;     // of the tilt, likewise
constexpr double kLookEvery = 0.1;   // whether insertion is held up [s]
constexpr double kHeldUp = 0.1;      // of the inserting speed: slower than that it is
constexpr double kShallow = 3;       // lifts below the face: there the face may hold it up
constexpr double kProbing = 0.5;     // of the tilt rate
constexpr double kMostTilt = 0.02;   // that it tries, from straight [rad]

HandTwist along(double velocity) noexcept {
  HandTwist v = HandTwist::Zero();
  v[0] = velocity;
  return v;
}

}  // namespace

SearchLaw::SearchLaw(std::span<const double> g) noexcept
    : n_{g[0], g[1], g[2],  g[3],  g[4],  g[5],  g[6],  g[7],
         g[8], g[9], g[10], g[11], g[12], g[13], g[14], g[15]},
      search_({n_.fibre_radius, n_.bore_radius, n_.mouth_radius, n_.lead_in_length,
               n_.near_entrance, n_.tilt, n_.lift}) {
  static_assert(sizeof(Numbers) == kSearchGains.size() * sizeof(double));
}

HandTwist SearchLaw::command(const Observation& observation) noexcept {
  Observation o = observation;
  o.wrench -= tare_;
  smooth_ += kSmoothing * (o.wrench - smooth_);
  switch (phase_) {
    case Phase::approach:
      return approach(o);
    case Phase::touch:
      return touch(o);
    case Phase::release:
      return release(o);
    case Phase::lift:
      return lift(o);
    case Phase::move:
      return move(o);
    case Phase::lower:
      return lower(o);
    case Phase::insert:
      return insert(o);
    case Phase::straighten:
      break;
  }
  return straighten(o);
}

// Stands still for this period.
HandTwist SearchLaw::begin(Phase phase, const Observation& o) noexcept {
  phase_ = phase;
  since_ = o.time;
  from_ = o.displacement[0];
  sum_ = 0;
  read_ = 0;
  probe_ = 0;
  if (phase == Phase::insert) search_.straightened();
  return HandTwist::Zero();
}

double SearchLaw::felt_force() const noexcept {
  return std::max(n_.touch_force, kNoises * std::sqrt(noise_));
}

HandTwist SearchLaw::approach(const Observation& o) noexcept {
  if (o.wrench[0] > felt_force()) return begin(Phase::touch, o);
  if (o.height < -n_.near_entrance) return begin(Phase::insert, o);
  ++free_;
  if (free_ > 1) noise_ += (o.wrench[0] * o.wrench[0] - noise_) / free_;
  tare_ += o.wrench / free_;
  return along(o.height < n_.near_entrance ? -n_.touch_speed : -n_.approach_speed);
}

HandTwist SearchLaw::touch(const Observation& o) {
  const double rested = o.time - since_;
  if (rested < kSettling * n_.hold_time) return along(0);
  sum_ += o.wrench[0];
  ++read_;
  if (rested < n_.hold_time) return along(0);
  const double f = sum_ / read_, x = o.displacement[0];
  const bool first = stiffness_ == 0;
  if (first && rest_force_ == 0) {
    if (f < 0.5 * felt_force()) return begin(Phase::approach, o);  // it was noise
    rest_at_ = x;
    rest_force_ = f;
    return begin(Phase::release, o);
  }
  if (first) stiffness_ = (rest_force_ - f) / (x - rest_at_);
  if (!first && f < 0.5 * felt_force()) return begin(Phase::lower, o);
  search_.rested({x + f / stiffness_, o.displacement.segment<2>(1), o.displacement.tail<2>()},
                 o.height);
  return begin(Phase::lift, o);
}

// Unlike under a growing force, nothing slides on a slope while it gives way.
HandTwist SearchLaw::release(const Observation& o) noexcept {
  if (o.wrench[0] > kLeft * rest_force_) return along(kReleasing * n_.touch_speed);
  return begin(Phase::touch, o);
}

HandTwist SearchLaw::lift(const Observation& o) noexcept {
  const double held = smooth_.head<3>().norm();
  const double free = std::max(n_.touch_force, kSmoothNoises * std::sqrt(noise_));
  const bool high = o.displacement[0] >= std::max(from_, search_.highest_rest()) + n_.lift;
  return high && held < free ? begin(Phase::move, o) : along(n_.insert_speed);
}

HandTwist SearchLaw::tilted_to(const Vector2d& tilt, const Observation& o) const noexcept {
  HandTwist v = HandTwist::Zero();
  v.tail<2>() = (tilt - o.displacement.tail<2>()) / kGoalTime;
  const double rate = v.tail<2>().norm();
  if (rate > n_.tilt_rate) v.tail<2>() *= n_.tilt_rate / rate;
  return v;
}

HandTwist SearchLaw::move(const Observation& o) noexcept {
  const TouchPlace& next = search_.next();
  const Vector2d left = next.across - o.displacement.segment<2>(1);
  const bool tilted = (next.tilt - o.displacement.tail<2>()).norm() < kTilted * n_.tilt;
  if (left.norm() < kThere * n_.fibre_radius && tilted) return begin(Phase::lower, o);
  HandTwist v = tilted_to(next.tilt, o);
  v.segment<2>(1) = left / kGoalTime;
  return limit_speed(v, n_.insert_speed);
}

HandTwist SearchLaw::lower(const Observation& o) noexcept {
  if (o.wrench[0] > felt_force()) return begin(Phase::touch, o);
  const double x = o.displacement[0];
  if (x < search_.lowest_rest() - n_.lift)
    return begin(o.height < -n_.lift ? Phase::insert : Phase::approach, o);
  const bool near = x < search_.highest_rest() + kClear * n_.lift;
  return along(near ? -n_.touch_speed : -n_.insert_speed);
}

HandTwist SearchLaw::insert(const Observation& o) noexcept {
  if (o.time - since_ >= kLookEvery) {
    const bool held_up = from_ - o.displacement[0] < kHeldUp * n_.insert_speed * kLookEvery;
    const bool shallow =
        search_.begun() && o.displacement[0] > search_.lowest_rest() - kShallow * n_.lift;
    begin(!held_up ? Phase::insert : shallow ? Phase::touch : Phase::straighten, o);
  }
  const Eigen::Vector3d f = o.wrench.head<3>();
  const double pressed = f.squaredNorm() / (n_.push_force * n_.push_force);
  HandTwist v = tilted_to(straight_, o) * (kGoalTime / kTiltTime);
  v[0] = -n_.insert_speed * std::max(0.0, 1 - pressed);
  v.segment<2>(1) = n_.yield * f.tail<2>();
  return v;
}

HandTwist SearchLaw::straighten(const Observation& o) noexcept {
  if (probe_ == 0 && o.displacement[0] < from_ + n_.lift) return along(n_.touch_speed);
  const auto axis = static_cast<Eigen::Index>(probe_ / 3);
  const std::size_t step = probe_ % 3;
  const double tilt = o.displacement[3 + axis], middle = 0.5 * (resisted_[0] + resisted_[1]);
  const double way = step == 1 ? -1 : 1;
  const bool there = step == 2 ? tilt >= middle
                               : way * (tilt - straight_[axis]) > kMostTilt ||
                                     way * smooth_[3 + axis] < -n_.turn_moment;
  HandTwist v = along(0);
  if (!there) {
    v[3 + axis] = way * (step == 2 ? 1 : kProbing) * n_.tilt_rate;
    return v;
  }
  if (step == 2)
    straight_[axis] = middle;
  else
    resisted_[step] = tilt;
  return ++probe_ == 6 ? begin(Phase::insert, o) : v;
}

}  // namespace ferrule
