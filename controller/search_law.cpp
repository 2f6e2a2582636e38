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
constexpr double kGently = 0.1;     // of the lift: that far it comes off gently
constexpr double kThere = 1e-3;     // of r: that near a place it is there
constexpr double kTilted = 0.01;    // of the tilt, likewise
constexpr double kGoalTime = 0.01;  // with which it settles at a place [s]
constexpr double kTiltTime = 0.1;   // and at a tilt, inserting [s]

// Of a hand that is late.
constexpr double kGoalLags = 2.7;  // it settles with at least: from e of them on without overshoot
constexpr double kBrakeTime = 2e-3;    // with which it comes down to touch [s]
constexpr double kBrakeLags = 4;       // and at least: without overshoot of a lag, too
constexpr double kStopForce = 0.95;    // of the pushing force: what a touch may come to
constexpr double kStopPull = 1.35;     // likewise: where it comes off, or turns
constexpr double kMostFelt = 0.5;      // of the pushing force: what it feels at least
constexpr double kStopTime = 2.86e-3;  // of touching speed, for the pushing force, unknown [s]
constexpr double kSteadyForce = 0.25;  // of the pushing force: so much may go on in the bore
constexpr double kStopLift = 0.5;      // of the lift, likewise
constexpr double kFurther = 1.25;      // of what a cone may be higher

// Of how it centres in a cone.
constexpr std::array kCentreAt = {0.5, 0.15};  // of the lead-in's length
constexpr double kCentreBelow = 0.45;          // likewise: the second time
constexpr double kHeldPlay = 1.3;              // of how far a touch holds it: there is as much play
constexpr double kBefore = 0.3, kBehind = 0;   // of near the entrance, once its height is known

// Of how it inserts.
constexpr double kLookEvery = 0.1;  // whether it is held up [s]
constexpr double kLookLags = 1.5;   // and in no less than so many lags: a late hand sets out late
constexpr double kHeldUp = 0.1;     // of the inserting speed: slower than that it is
constexpr double kShallow = 3;      // lifts below the face: there the face may hold it up
constexpr double kFreed = 0.5;      // of the pushing force: less is left before it turns
constexpr double kProbing = 0.5;    // of the tilt rate
constexpr double kLeastTurning = 0.2;  // of that
constexpr double kMostTilt = 0.02;     // that it tries, from straight [rad]
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
  const HandTwist meant = answer(o);
  return meant / hand_.gain();
}

HandTwist SearchLaw::answer(const Observation& o) {
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
  relaxed_ = false;
  if (phase == Phase::insert) search_.straightened();
  return HandTwist::Zero();
}

double SearchLaw::felt_moment() const noexcept {
  return std::max(n_.turn_moment, kSmoothNoises * std::sqrt(noise_.tail<2>().maxCoeff()));
}

// A speed from which the holder, late as it is, does not go on by more than `further`.
double SearchLaw::stoppable(double speed, double further) const noexcept {
  return speed * hand_.delay() > further ? further / hand_.delay() : speed;
}

// It has to touch more slowly for its delay.
bool SearchLaw::late() const noexcept {
  return touching() < n_.touch_speed;
}

// He knows that a push moves his gripper by more than the end is lifted.
bool SearchLaw::gives_way() const noexcept {
  return known_.stiffness > 0 && n_.push_force / known_.stiffness > n_.lift;
}

double SearchLaw::stiffness() const noexcept {
  if (stiffness_ > 0) return stiffness_;
  return known_.stiffness > 0 ? known_.stiffness : n_.push_force / (kStopTime * n_.touch_speed);
}

// At which a touch that it feels then comes to as much as it may.
double SearchLaw::touching(double speed) const noexcept {
  return stoppable(speed, (kStopForce * n_.push_force - felt_force()) / stiffness());
}

double SearchLaw::touching() const noexcept {
  return touching(n_.touch_speed);
}

// At which it notices a pull as large as its push.
double SearchLaw::pulling() const noexcept {
  return stoppable(n_.touch_speed, (kStopPull - 1) * n_.push_force / stiffness());
}

// A tilted end gives way in the bore, and comes to rest in parts of the lift.
double SearchLaw::inserting() const noexcept {
  const double soft = stiffness_ > 0 ? kSteadyForce * n_.push_force / stiffness_ : 0;
  return stoppable(n_.insert_speed, std::max(soft, kStopLift * n_.lift));
}

double SearchLaw::goal_time() const noexcept {
  return std::max(kGoalTime, kGoalLags * hand_.delay());
}

double SearchLaw::felt_force() const noexcept {
  const double above_noise = std::max(n_.touch_force, kNoises * std::sqrt(noise_[0]));
  return std::min(above_noise, kMostFelt * n_.push_force);
}

double SearchLaw::felt_smooth_force() const noexcept {
  return std::max(n_.touch_force, kSmoothNoises * std::sqrt(noise_[0]));
}

HandTwist SearchLaw::approach(const Observation& o) noexcept {
  const bool still = o.time < n_.hold_time;  // at first, for the noise
  if (!still && o.wrench[0] > felt_force()) return begin(Phase::touch, o);
  const double height = o.height - entrance_;
  if (height < -behind_) return begin(Phase::insert, o);
  ++free_;
  if (free_ > 1) noise_ += (o.wrench.cwiseAbs2() - noise_) / free_;
  tare_ += o.wrench / free_;
  if (still) return along(0);
  if (since_ < n_.hold_time) since_ = o.time;
  if (height < before_) return along(-touching());
  if (rest_force_ == 0)
    hand_.moved(from_[0] - o.displacement[0], o.time - since_, n_.approach_speed);
  if (time_to_centre(o)) {
    centre_ = to_centre_ == 2 ? ConeCentre::roughly(search_.play(o.height)) : ConeCentre::finely();
    return begin(Phase::centre, o);
  }
  return along(known_.stiffness > 0 ? -touching(n_.approach_speed) : -n_.approach_speed);
}

HandTwist SearchLaw::touch(const Observation& o) {
  const double rested = o.time - since_;
  if (rested < hand_.delay() + kSettling * n_.hold_time) return along(0);
  sum_ += o.wrench[0];
  ++read_;
  const bool first = stiffness_ == 0;
  const double f = sum_ / read_, x = o.displacement[0];
  // What the mean may be wrong by.
  const double error =
      first ? kForceError * felt_force() : kHeightError * n_.fibre_radius * stiffness_;
  if (rested < hand_.delay() + n_.hold_time || noise_[0] > read_ * error * error) return along(0);
  const double sideways = smooth_.segment<2>(1).norm();
  if (!late() && sideways > kSlides * f && f > 0.5 * felt_force()) return begin(Phase::insert, o);
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
  if (o.wrench[0] < -n_.push_force) return begin(Phase::insert, o);  // so fast it is in the bore
  const double x = o.displacement[0], held = smooth_.head<3>().norm();
  const bool high = x >= std::max(from_[0], search_.highest_rest()) + n_.lift;
  if (high && held < felt_smooth_force()) return begin(Phase::move, o);
  return along(x < from_[0] + kGently * n_.lift ? pulling() : n_.insert_speed);
}

HandTwist SearchLaw::sideways_to(const Vector2d& place, const Observation& o) const noexcept {
  HandTwist v = HandTwist::Zero();
  v.segment<2>(1) = (place - o.displacement.segment<2>(1)) / goal_time();
  return limit_speed(v, n_.insert_speed);
}

bool SearchLaw::is_at(const Vector2d& place, const Observation& o) const noexcept {
  return (place - o.displacement.segment<2>(1)).norm() < kThere * n_.fibre_radius;
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
  const bool tilted = (next.tilt - o.displacement.tail<2>()).norm() < kTilted * n_.tilt;
  if (is_at(next.across, o) && tilted) return begin(Phase::lower, o);
  return tilted_to(next.tilt, goal_time(), o) + sideways_to(next.across, o);
}

HandTwist SearchLaw::lower(const Observation& o) noexcept {
  if (o.wrench[0] > felt_force()) return begin(Phase::touch, o);
  const double x = o.displacement[0];
  if (x + smooth_[0] / stiffness_ < search_.lowest_rest() - n_.lift)
    return begin(o.height < -n_.lift ? Phase::insert : Phase::approach, o);
  double clear = search_.highest_rest() + kClear * n_.lift;
  if (late()) clear += kFurther * search_.climb();
  const double braking = (x - clear) / std::max(kBrakeTime, kBrakeLags * hand_.delay());
  return along(-std::clamp(braking, touching(), n_.insert_speed));
}

HandTwist SearchLaw::insert(const Observation& o) noexcept {
  const double look = std::max(kLookEvery, kLookLags * hand_.delay());
  if (o.time - since_ >= look) {
    const bool held_up = from_[0] - o.displacement[0] < kHeldUp * inserting() * look;
    const bool shallow = search_.begun() && o.height - entrance_ > -n_.near_entrance &&
                         o.displacement[0] > search_.lowest_rest() - kShallow * n_.lift;
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
  return off || o.wrench[0] < -n_.push_force ? begin(Phase::straighten, o) : along(pulling());
}

// About y and z one way and the other until the bore resists, or far enough, and to the middle,
// which `from_` has then. Along the bore it gives way all the time, and turns slower where a late
// hand would let the force there grow too much.
HandTwist SearchLaw::straighten(const Observation& o) noexcept {
  HandTwist v =
      along(std::clamp(o.wrench[0] / (stiffness() * goal_time()), -touching(), touching()));
  relaxed_ = relaxed_ || std::abs(smooth_[0]) < 0.5 * felt_force();
  if (!relaxed_) return v;
  const Eigen::Index axis = 3 + static_cast<Eigen::Index>(probe_ / 3);
  const std::size_t step = probe_ % 3;
  const double force = std::max(std::abs(o.wrench[0]), std::abs(smooth_[0])) / n_.push_force;
  const double slower = late() ? std::clamp(kStopPull - force, kLeastTurning, 1.0) : 1;
  const double rate =
      slower * kProbing * n_.tilt_rate * kGoalTime / std::max(kGoalTime, hand_.delay());
  const double at = o.displacement[axis], middle = 0.5 * (resisted_[0] + resisted_[1]);
  const double way = step == 1 ? -1 : 1;
  const double past = way * (at - from_[axis]);  // before, it is held where it comes from
  const bool resists =
      past >= 0 && (way * smooth_[axis] < -felt_moment() || std::abs(o.wrench[0]) > n_.push_force);
  const bool there = step == 2 ? at + hand_.delay() * rate >= middle : resists || past > kMostTilt;
  if (!there) {
    v[axis] = way * rate;
    return v;
  }
  if (step == 2)
    from_[axis] = middle;
  else
    resisted_[step] = at;
  if (++probe_ < kProbes) return v;
  straight_ = from_.tail<2>();
  push_ = harder(push_, n_.push_force);
  return begin(Phase::insert, o);
}

// The second time no lower than where the end comes off the cone before it is in the middle.
bool SearchLaw::time_to_centre(const Observation& o) const noexcept {
  if (!(late() || gives_way()) || !hand_.measured() || to_centre_ == 0) return false;
  const double length = n_.lead_in_length;
  if (to_centre_ == 2) return o.height < kCentreAt[0] * length;
  return o.height < std::clamp(search_.height_of(kHeldPlay * held_), kCentreAt[1] * length,
                               kCentreBelow * length);
}

// The cone is felt along the bore first, where the holder is stiff, and otherwise sideways.
HandTwist SearchLaw::centre(const Observation& o) noexcept {
  const Vector2d at = o.displacement.segment<2>(1);
  const SidewaysMove& next = centre_.next();
  const double force = gives_way() ? smooth_.segment<2>(1).norm() : smooth_[0];
  const double felt = gives_way() ? felt_force() : felt_smooth_force();
  if (next.until_felt) {
    at_cone_ = at_cone_ && force > 0.5 * felt;
    if (!at_cone_ && force > felt) {
      centre_.arrived(at);
      at_cone_ = true;
    } else if ((at - from_.segment<2>(1)).norm() > 2 * search_.play(o.height)) {
      to_centre_ = 0;  // there is none
      return begin(Phase::approach, o);
    }
    HandTwist v = HandTwist::Zero();
    v.segment<2>(1) = n_.insert_speed * next.to;
    return centre_.next().until_felt ? v : along(0);
  }
  if (smooth_[0] < -felt) held_ = std::max(held_, (at - centre_.touched()).norm());
  if (!is_at(next.to, o)) return sideways_to(next.to, o);
  centre_.arrived(at);
  if (centre_.ended()) {
    centred(o);
    return begin(Phase::approach, o);
  }
  return along(0);
}

void SearchLaw::centred(const Observation& o) noexcept {
  search_.recognise_cone();
  if (--to_centre_ > 0) return;
  entrance_ =
      std::clamp(o.height - search_.height_of(centre_.play()), -n_.near_entrance, n_.near_entrance);
  before_ = kBefore * n_.near_entrance;
  behind_ = kBehind * n_.near_entrance;
}

}  // namespace ferrule
