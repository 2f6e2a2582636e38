#include "controller/search_law.hpp"

#include <algorithm>
#include <cmath>

namespace ferrule {
namespace {

using Eigen::Vector2d;

// Of what it feels.
constexpr double kNoises = 6;         // standard deviations of the sensor that it does not reach
constexpr double kSmoothNoises = 2;   // the same of the smoothed wrench
constexpr double kSmoothing = 0.05;   // share of a new reading in that
constexpr double kSettling = 0.4;     // of the time it rests, before the force counts
constexpr double kForceError = 0.02;  // of what is felt, where it tells the stiffness
constexpr double kLeft = 0.4;         // of the force, where it has given way
constexpr double kReleased = 0.7;     // less than that is enough
constexpr double kSlides = 0.5;       // of the axial force: with more sideways it lies on a slope
constexpr double kReleasing = 0.25;   // of the touching speed

// Of where it goes.
constexpr double kClear = 0.25;     // of the lift: above what can be in the way
constexpr double kThere = 1e-3;     // of r: that near a place it is there
constexpr double kTilted = 0.01;    // of the tilt, likewise
constexpr double kGoalTime = 0.01;  // with which it settles at a place [s]
constexpr double kTiltTime = 0.1;   // and at a tilt, inserting [s]

// Of a hand that is late.
constexpr double kLagTime = 0.25;  // so long it is measured [s]
constexpr double kLagLags = 5;     // and at least so many times itself
constexpr double kGoalLags = 2.7;  // it settles with at least: from e of them on without overshoot
constexpr double kStopForce = 0.75;  // of the pushing force: so much may a touch with it add
constexpr double kStopTime = 5e-3;   // of touching speed: what moves the end that far, unknown [s]
constexpr double kSteadyForce = 0.25;  // of the pushing force: so much may go on in the bore
constexpr double kStopLift = 0.3;      // of the lift, likewise
constexpr double kLate = 2e-3;         // with more it does not touch the cone of a lead-in [s]
constexpr double kFurther = 1.25;      // of what a cone may be higher

// Of how it inserts.
constexpr double kLookEvery = 0.1;  // whether it is held up [s]
constexpr double kLookLags = 1.5;   // and in no less than so many lags: a late hand sets out late
constexpr double kHeldUp = 0.1;     // of the inserting speed: slower than that it is
constexpr double kShallow = 3;      // lifts below the face: there the face may hold it up
constexpr double kFreed = 0.5;      // of the pushing force: less is left before it turns
constexpr double kProbing = 0.5;    // of the tilt rate
constexpr double kMostTilt = 0.02;  // that it tries, from straight [rad]
constexpr std::size_t kProbes = 6;

HandTwist along(double velocity) noexcept {
  HandTwist v = HandTwist::Zero();
  v[0] = velocity;
  return v;
}

}  // namespace

SearchLaw::SearchLaw(std::span<const double> g, const KnownHand& hand) noexcept
    : n_{g[0], g[1], g[2],  g[3],  g[4],  g[5],  g[6],  g[7],
         g[8], g[9], g[10], g[11], g[12], g[13], g[14], g[15]},
      known_(hand),
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
    case Phase::centre:
      return centre(o);
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
    case Phase::back_off:
      return back_off(o);
    case Phase::straighten:
      break;
  }
  return straighten(o);
}

// Stands still for this period.
HandTwist SearchLaw::begin(Phase phase, const Observation& o) noexcept {
  phase_ = phase;
  since_ = o.time;
  from_ = o.displacement;
  sum_ = 0;
  read_ = 0;
  probe_ = 0;
  if (phase == Phase::insert) search_.straightened();
  return HandTwist::Zero();
}

double SearchLaw::felt_moment() const noexcept {
  return std::max(n_.turn_moment, kSmoothNoises * std::sqrt(noise_.tail<2>().maxCoeff()));
}

// By how much the holder is late, on its way straight in at one speed since the start. The speed it
// has reached is its mean over at least the last half of that time: a supervisor lets it go by fits
// and starts where the sensor is noisy.
void SearchLaw::measure_lag(const Observation& o) noexcept {
  const double time = o.time - since_, x = o.displacement[0];
  if (time > std::max(kLagTime, kLagLags * lag_)) return;
  if (time >= 2 * marks_[1].time) marks_ = {marks_[1], {time, x}};
  const auto [before, from] = marks_[0];
  if (x < from) lag_ = std::max(0.0, time - x * (time - before) / (x - from));
}

// A speed from which the holder, late as it is, does not go on by more than `further`.
double SearchLaw::stoppable(double speed, double further) const noexcept {
  return speed * lag_ > further ? further / lag_ : speed;
}

// Of the hand, in which the force of a touch grows by part of the pushing force.
double SearchLaw::touching_way() const noexcept {
  const double k = stiffness_ > 0 ? stiffness_ : known_.stiffness;
  return kStopForce * (k > 0 ? n_.push_force / k : kStopTime * n_.touch_speed);
}

double SearchLaw::touching() const noexcept {
  return stoppable(n_.touch_speed, touching_way());
}

// A tilted end gives way in the bore, and comes to rest in parts of the lift.
double SearchLaw::inserting() const noexcept {
  const double soft = stiffness_ > 0 ? kSteadyForce * n_.push_force / stiffness_ : 0;
  return stoppable(n_.insert_speed, std::max(soft, kStopLift * n_.lift));
}

double SearchLaw::goal_time() const noexcept {
  return std::max(kGoalTime, kGoalLags * lag_);
}

double SearchLaw::felt_force() const noexcept {
  return std::max(n_.touch_force, kNoises * std::sqrt(noise_[0]));
}

HandTwist SearchLaw::approach(const Observation& o) noexcept {
  const bool still = o.time < n_.hold_time;  // at first, for the noise
  if (!still && o.wrench[0] > felt_force()) return begin(Phase::touch, o);
  if (o.height < -n_.near_entrance) return begin(Phase::insert, o);
  ++free_;
  if (free_ > 1) noise_ += (o.wrench.cwiseAbs2() - noise_) / free_;
  tare_ += o.wrench / free_;
  if (still) return along(0);
  if (since_ < n_.hold_time) since_ = o.time;
  if (o.height < n_.near_entrance) return along(-touching());
  if (!centred_ && rest_force_ == 0 && known_.lag == 0) measure_lag(o);
  if (!centred_ && lag_ > kLate && o.height < 0.5 * n_.lead_in_length) {
    centred_ = true;
    return begin(Phase::centre, o);
  }
  const double approaching =
      known_.stiffness > 0 ? stoppable(n_.approach_speed, touching_way()) : n_.approach_speed;
  return along(-approaching);
}

HandTwist SearchLaw::touch(const Observation& o) {
  const double rested = o.time - since_;
  if (rested < lag_ + kSettling * n_.hold_time) return along(0);
  sum_ += o.wrench[0];
  ++read_;
  const bool first = stiffness_ == 0;
  const double f = sum_ / read_, x = o.displacement[0];
  // What the mean may be wrong by.
  const double error =
      first ? kForceError * felt_force() : kHeightError * n_.fibre_radius * stiffness_;
  if (rested < lag_ + n_.hold_time || noise_[0] > read_ * error * error) return along(0);
  if (smooth_.segment<2>(1).norm() > kSlides * f && f > 0.5 * felt_force())
    return begin(Phase::insert, o);
  if (first && rest_force_ == 0) {
    if (f < 0.5 * felt_force()) return begin(Phase::approach, o);  // it was noise
    rest_at_ = x;
    rest_force_ = f;
    return begin(Phase::release, o);
  }
  if (first && !(f < kReleased * rest_force_)) return begin(Phase::release, o);
  if (first) stiffness_ = (rest_force_ - f) / (x - rest_at_);
  if (!first && f < 0.5 * felt_force()) return begin(Phase::lower, o);
  search_.rested({x + f / stiffness_, o.displacement.segment<2>(1), o.displacement.tail<2>()},
                 o.height);
  return begin(Phase::lift, o);
}

// Unlike under a growing force, nothing slides on a slope while it gives way.
HandTwist SearchLaw::release(const Observation& o) noexcept {
  if (o.wrench[0] > kLeft * rest_force_) return along(kReleasing * touching());
  return begin(Phase::touch, o);
}

HandTwist SearchLaw::lift(const Observation& o) noexcept {
  if (smooth_[0] < -n_.push_force) return begin(Phase::insert, o);  // so fast it is in the bore
  const double held = smooth_.head<3>().norm();
  const double free = std::max(n_.touch_force, kSmoothNoises * std::sqrt(noise_[0]));
  const bool high = o.displacement[0] >= std::max(from_[0], search_.highest_rest()) + n_.lift;
  if (high && held < free) return begin(Phase::move, o);
  return along(n_.insert_speed);
}

HandTwist SearchLaw::tilted_to(const Vector2d& tilt, double time,
                               const Observation& o) const noexcept {
  HandTwist v = HandTwist::Zero();
  v.tail<2>() = (tilt - o.displacement.tail<2>()) / time;
  const double rate = v.tail<2>().norm();
  if (rate > n_.tilt_rate) v.tail<2>() *= n_.tilt_rate / rate;
  return v;
}

HandTwist SearchLaw::move(const Observation& o) noexcept {
  const TouchPlace& next = search_.next();
  const Vector2d left = next.across - o.displacement.segment<2>(1);
  const bool tilted = (next.tilt - o.displacement.tail<2>()).norm() < kTilted * n_.tilt;
  if (left.norm() < kThere * n_.fibre_radius && tilted) return begin(Phase::lower, o);
  HandTwist v = tilted_to(next.tilt, goal_time(), o);
  v.segment<2>(1) = left / goal_time();
  return limit_speed(v, n_.insert_speed);
}

HandTwist SearchLaw::lower(const Observation& o) noexcept {
  if (o.wrench[0] > felt_force()) return begin(Phase::touch, o);
  const double x = o.displacement[0];
  if (x + smooth_[0] / stiffness_ < search_.lowest_rest() - n_.lift)
    return begin(o.height < -n_.lift ? Phase::insert : Phase::approach, o);
  double clear = search_.highest_rest() + kClear * n_.lift;
  if (lag_ > kLate) clear += kFurther * search_.climb() + lag_ * n_.insert_speed;
  return along(x < clear ? -touching() : -n_.insert_speed);
}

HandTwist SearchLaw::insert(const Observation& o) noexcept {
  const double look = std::max(kLookEvery, kLookLags * lag_);
  if (o.time - since_ >= look) {
    const bool held_up = from_[0] - o.displacement[0] < kHeldUp * inserting() * look;
    const bool shallow =
        search_.begun() && o.displacement[0] > search_.lowest_rest() - kShallow * n_.lift;
    begin(!held_up ? Phase::insert : shallow ? Phase::touch : Phase::back_off, o);
  }
  const Eigen::Vector3d f = o.wrench.head<3>();
  const Eigen::Vector3d push(std::max(0.0, f[0]), f[1], f[2]);  // what pulls is no reason to stop
  const double pressed = push.squaredNorm() / (push_ * push_);
  HandTwist v = tilted_to(straight_, std::max(goal_time(), kTiltTime), o);
  v[0] = -inserting() * std::max(0.0, 1 - pressed);
  v.segment<2>(1) = n_.yield * f.tail<2>();
  return v;
}

// Until nothing presses any more; no further where it is held back.
HandTwist SearchLaw::back_off(const Observation& o) noexcept {
  const double freed = kFreed * n_.push_force;
  const bool off = o.displacement[0] >= from_[0] + n_.lift && smooth_[0] < freed;
  return off || smooth_[0] < -freed ? begin(Phase::straighten, o) : along(touching());
}

HandTwist SearchLaw::straighten(const Observation& o) noexcept {
  const double rate = kProbing * n_.tilt_rate * kGoalTime / std::max(kGoalTime, lag_);
  HandTwist v = probe(o, 3, rate, kMostTilt, felt_moment());
  if (probe_ < kProbes) return v;
  straight_ = from_.tail<2>();
  push_ = kHarder * n_.push_force;
  return begin(Phase::insert, o);
}

HandTwist SearchLaw::centre(const Observation& o) noexcept {
  const double most = n_.mouth_radius - n_.bore_radius;
  const HandTwist v = probe(o, 1, n_.insert_speed, most, felt_force());
  const bool nothing = probe_ == 3 && resisted_[0] - resisted_[1] > 2 * most;
  return probe_ < kProbes && !nothing ? v : begin(Phase::approach, o);
}

// Along the coordinate `first` and the next one, at `speed` one way and the other until something
// resists by `felt`, or `most` further, and to the middle, which `from_` has then.
HandTwist SearchLaw::probe(const Observation& o, Eigen::Index first, double speed, double most,
                           double felt) noexcept {
  const Eigen::Index axis = first + static_cast<Eigen::Index>(probe_ / 3);
  const std::size_t step = probe_ % 3;
  const double at = o.displacement[axis], middle = 0.5 * (resisted_[0] + resisted_[1]);
  const double way = step == 1 ? -1 : 1;
  const double past = way * (at - from_[axis]);  // before, it is held where it comes from
  const bool resists =
      past >= 0 && (way * smooth_[axis] < -felt || smooth_[0] > kStopForce * n_.push_force);
  const bool there = step == 2 ? at + lag_ * speed >= middle : resists || past > most;
  HandTwist v = along(0);
  if (!there) {
    v[axis] = way * speed;
    return v;
  }
  if (step == 2)
    from_[axis] = middle;
  else
    resisted_[step] = at;
  ++probe_;
  return v;
}

}  // namespace ferrule
