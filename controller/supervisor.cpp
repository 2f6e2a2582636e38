#include "controller/supervisor.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "insertion/scene_scaling.hpp"
#include "sim/base/elementary.hpp"

namespace ferrule {
namespace {

constexpr double kSlow = 0.1;      // of the speed: held by the force below it, or hardly pressing
constexpr double kAside = 0.1;     // of the force: a lateral force that tells where to go
constexpr double kHugest = 1e100;  // components beyond are cut, so that their squares are finite
constexpr double kToFullSpeed = 2e-3;  // [s]
constexpr double kRounding = 1e-9;     // of the speed
constexpr double kLeastForce = 0.25;   // of the force limit, to brake for: less stops everything
constexpr double kDeviations = 4;      // of noise and bias, that the margin covers

const double kGoldenAngle = std::numbers::pi * (3 - std::sqrt(5.0));  // 137.5 degrees

// `v` no longer than `length`.
HandTwist cut(const HandTwist& v, double length) noexcept {
  const double norm = v.norm();
  return norm > length ? HandTwist(v * (length / norm)) : v;
}

double largest_eigenvalue(const Eigen::MatrixXd& symmetric) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(symmetric).eigenvalues().maxCoeff();
}

// The part of `v` that does not relieve a felt `force`.
HandTwist straining_part(const HandTwist& v, const Eigen::Vector3d& force) noexcept {
  const double f = force.norm();
  HandTwist w = v;
  if (!(f > 0)) return w;
  const Eigen::Vector3d along = force / f;
  w.head<3>() -= std::max(0.0, along.dot(v.head<3>())) * along;
  return w;
}

// The same, or all of `v` where that is the greater part: what is left when it is braked would go
// where nobody wanted to.
HandTwist straining_unturned(const HandTwist& v, const Eigen::Vector3d& force) noexcept {
  const HandTwist straining = straining_part(v, force);
  return 2 * straining.squaredNorm() > v.squaredNorm() ? v : straining;
}

}  // namespace

SupervisorLimits supervisor_limits(const Scene& scene) {
  const Scaling scaling = scene_scaling(scene);
  const Holder& holder = scene.world.holder;
  Matrix5 stiffness = holder.stiffness;
  // At which a tilt strains the holder half as much as a motion that is stiffest, so that with both
  // together, coupled as they are in a fibre, that motion stays the stiffest.
  const double lever = std::sqrt(2 * largest_eigenvalue(stiffness.bottomRightCorner<2, 2>()) /
                                 largest_eigenvalue(stiffness.topLeftCorner<3, 3>()));
  stiffness.bottomRows<2>() /= lever;
  stiffness.rightCols<2>() /= lever;
  SupervisorLimits limits;
  limits.speed = scaling.motion * scene.limits.speed;
  limits.force = scaling.force * scene.limits.force;
  limits.acceleration = limits.speed / kToFullSpeed;
  limits.stiffness = largest_eigenvalue(stiffness) * scaling.force / scaling.motion;
  const ForceSensorModel& sensor = scene.sensor;
  limits.follows = -elementary::expm1(-2 * std::numbers::pi * sensor.bandwidth * limits.period);
  limits.misread =
      scaling.force * (kDeviations * sensor.deviation(scene.limits.force,
                                                      scene.limits.time) +
                       sensor.dead_band + sensor.resolution);  // half of it now, half in the tare
  limits.late = scene.hand.gain * (scene.hand.delay + scene.hand.smoothing);
  limits.lever = scaling.motion * lever;
  limits.disagreement = 0.2 * limits.speed;
  limits.jam_force = 0.25 * limits.force;
  limits.retreat = scaling.motion * 20e-6;
  limits.offset = scaling.motion * 10e-6;
  return limits;
}

double SupervisorLimits::brakes_for() const noexcept {
  return std::max(std::min((1 - margin) * force, force - misread), kLeastForce * force);
}

std::string cannot_hold(const SupervisorLimits& limits) {
  const double right = limits.force - limits.misread;
  if (right < kLeastForce * limits.force)
    return fmt::format(
        "the force limit cannot be held: the sensor may err by {:.3g} of it (four standard "
        "deviations of its errors); the supervisor brakes for {:.3g} of it",
        limits.misread / limits.force, limits.brakes_for() / limits.force);
  if (limits.stiffness * limits.speed * limits.late > right - limits.brakes_for())
    return fmt::format(
        "the force limit cannot be held: the hand is late, and goes on for {:.3g} ms after it was "
        "told to stop; the supervisor brakes for {:.3g} of the limit",
        1e3 * limits.late, limits.brakes_for() / limits.force);
  return {};
}

Supervisor::Supervisor(std::unique_ptr<Controller> inner, const SupervisorLimits& limits)
    : ControllerWrapper(std::move(inner)),
      limits_(limits),
      // At a steady speed s the way that is unseen is s T (1 - follows) / follows.
      stoppable_(speed_within(limits.brakes_for() / limits.stiffness,
                              limits.period * (1 - limits.follows) / limits.follows)),
      fastest_(std::min(limits.speed, stoppable_)) {}

HandTwist Supervisor::command(const Observation& observation) noexcept {
  pose_ += limits_.period * velocity_;
  unseen_ = (1 - limits_.follows) * (unseen_ + limits_.period * velocity_.norm());
  HandTwist wanted = inner_->command(observation);
  const bool finite = wanted.allFinite() && observation.wrench.allFinite();
  note(Intervention::not_finite, !finite);
  if (!finite && phase_ != Phase::stop) stop(Intervention::not_finite);
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  if (observation.wrench.allFinite()) force = observation.wrench.head<3>();

  if (phase_ == Phase::follow) {
    wanted = wanted.cwiseMax(-kHugest).cwiseMin(kHugest);
    wanted.tail<2>() *= limits_.lever;
    wanted = follow(observation, wanted);
  }
  if (phase_ == Phase::retreat || phase_ == Phase::shift) wanted = go_back(observation);
  if (phase_ == Phase::stop) wanted.setZero();

  velocity_ = keep_limits(wanted, force);
  if (phase_ == Phase::stop && velocity_.isZero(0)) supervision_.gave_up = reason_;
  HandTwist command = velocity_;
  command.tail<2>() /= limits_.lever;
  return command;
}

// The controller's velocity as far as it makes sense; may begin a retreat.
HandTwist Supervisor::follow(const Observation& observation, HandTwist wanted) noexcept {
  remember_way();
  note(Intervention::speed, wanted.head<3>().norm() > limits_.speed);
  wanted = slower_ * limit_speed(wanted, limits_.speed);

  const double apart = inner_->disagreement();
  const bool disagree = !(apart <= limits_.disagreement);
  note(Intervention::disagreement, disagree);
  if (disagree) wanted *= std::isfinite(apart) ? limits_.disagreement / apart : 0;
  const auto lasts = [&](bool now, double& since) {
    if (!now) since = -1;
    if (now && since < 0) since = observation.time;
    return now && observation.time - since >= limits_.patience;
  };
  const Eigen::Vector3d force = observation.wrench.head<3>();
  const double braked = braked_speed(by_now(force));
  const bool held = braked < kSlow * fastest_ && straining_unturned(wanted, force).norm() > braked;
  if (jammed(observation, wanted))
    give_way(Intervention::jam, observation);
  else if (lasts(held, held_since_))
    give_way(Intervention::held, observation);
  else if (lasts(disagree, disagreed_since_))
    give_way(Intervention::disagreement, observation);
  return wanted;
}

bool Supervisor::jammed(const Observation& observation, const HandTwist& wanted) noexcept {
  const double force = observation.wrench[0];
  if (!(wanted[0] < 0 && force > limits_.jam_force)) {
    pressed_since_ = -1;
    return false;
  }
  if (pressed_since_ < 0) {
    pressed_since_ = observation.time;
    depth_then_ = observation.depth;
    force_then_ = force;
    commanded_ = wanted_ = 0;
  }
  commanded_ -= limits_.period * velocity_[0];
  wanted_ -= limits_.period * wanted[0];
  if (observation.time - pressed_since_ < limits_.patience) return false;
  pressed_since_ = -1;  // looks again from now on
  const bool encoder_tells = observation.depth > 0 && depth_then_ > 0;
  const double moved = encoder_tells ? observation.depth - depth_then_ : commanded_;
  return wanted_ > kSlow * fastest_ * limits_.patience &&
         moved - (force - force_then_) / limits_.stiffness <
             std::max(0.5 * commanded_, kSlow * wanted_);
}

void Supervisor::give_way(Intervention why, const Observation& observation) noexcept {
  if (why != Intervention::disagreement) ++supervision_[why];
  if (tries_ == limits_.tries) {
    stop(why);
    return;
  }
  ++tries_;
  ++supervision_[Intervention::retreat];
  held_since_ = disagreed_since_ = -1;
  aside_.setZero();
  if (why == Intervention::disagreement) {
    slower_ *= 0.5;
  } else {
    const Eigen::Vector2d push = observation.wrench.segment<2>(1);
    Eigen::Vector2d move = limits_.offset * push.normalized();
    if (push.norm() < kAside * limits_.force) {
      // Sunflower spiral around where it began to search.
      const double n = ++searches_;
      const Eigen::Vector2d there =
          limits_.offset * std::sqrt(n) *
          Eigen::Vector2d(elementary::cos(n * kGoldenAngle), elementary::sin(n * kGoldenAngle));
      move = there - searched_;
      searched_ = there;
    }
    aside_.segment<2>(1) = move;
  }
  phase_ = Phase::retreat;
  to_go_ = kPerRetreat;
  phase_end_ =
      observation.time + limits_.patience + 3 * (limits_.retreat + aside_.norm()) / fastest_;
}

void Supervisor::stop(Intervention why) noexcept {
  phase_ = Phase::stop;
  reason_ = why;
}

void Supervisor::remember_way() noexcept {
  const auto last = [&]() -> HandPose& { return way_[(way_end_ + kWay - 1) % kWay]; };
  if (way_length_ > 0 && (pose_ - last()).norm() < limits_.retreat / kPerRetreat) return;
  way_[way_end_] = pose_;
  way_end_ = (way_end_ + 1) % kWay;
  way_length_ = std::min(way_length_ + 1, kWay);
}

// Velocity along the way back, then sideways; to following when there or when time is up.
HandTwist Supervisor::go_back(const Observation& observation) noexcept {
  const double spacing = limits_.retreat / kPerRetreat;
  if (phase_ == Phase::retreat) {
    while (to_go_ > 0 && way_length_ > 0) {
      const HandPose& point = way_[(way_end_ + kWay - 1) % kWay];
      if ((point - pose_).norm() > spacing) break;
      way_end_ = (way_end_ + kWay - 1) % kWay;
      --way_length_;
      --to_go_;
    }
    if (to_go_ == 0 || way_length_ == 0) {
      phase_ = Phase::shift;
      goal_ = pose_ + aside_;
      goal_[0] += to_go_ * spacing;  // nothing is known of the way before: straight back
    }
  }
  const bool retreating = phase_ == Phase::retreat;
  const HandPose goal = retreating ? way_[(way_end_ + kWay - 1) % kWay] : goal_;
  const HandPose path = goal - pose_;
  const double left = path.norm();
  if (observation.time >= phase_end_ || (!retreating && left < 1e-3 * spacing)) {
    phase_ = Phase::follow;
    pressed_since_ = -1;
  }
  const double speed = speed_within(left + (retreating ? (to_go_ - 1) * spacing : 0));
  return path * (std::min({fastest_, speed, left / limits_.period}) / std::max(left, 1e-300));
}

// The velocity closest to `wanted` that keeps the limits after the last one.
HandTwist Supervisor::keep_limits(const HandTwist& wanted, const Eigen::Vector3d& force) noexcept {
  const double change = limits_.acceleration * limits_.period, strength = by_now(force);
  const double most = std::max(limits_.force - limits_.misread, limits_.brakes_for());
  const double braked = braked_speed(strength);
  const bool following = phase_ == Phase::follow;

  HandTwist goal = cut(wanted, stoppable_);
  const HandTwist straining =
      following ? straining_unturned(goal, force) : straining_part(goal, force);
  const bool brakes = straining.norm() > braked;
  goal += cut(straining, braked) - straining;
  HandTwist v = velocity_ + cut(goal - velocity_, change);
  // On the way from one direction to another it may not brake as fast as it could: brake straight.
  if (straining_part(v, force).norm() > braked + kRounding * fastest_) {
    const HandTwist now = straining_part(velocity_, force);
    v = velocity_ - cut(now, change);
  }
  note(Intervention::force, following && brakes);
  note(Intervention::acceleration, following && (goal - velocity_).norm() > change * (1 + 1e-9));

  const HandTwist rest = straining_part(v, force);
  const bool stops =
      strength + limits_.stiffness * rest.norm() * limits_.period > most && rest.norm() > 0;
  note(Intervention::force_stop, stops);
  return stops ? HandTwist(v - rest) : v;
}

// The speed from which it stops within `distance` [m], the period in which it notices and a `lag`
// [s] included.
double Supervisor::speed_within(double distance, double lag) const noexcept {
  const double half = 0.5 * limits_.period + lag, a = limits_.acceleration;
  return a * (std::sqrt(half * half + 2 * std::max(0.0, distance) / a) - half);
}

double Supervisor::braked_speed(double force) const noexcept {
  return speed_within((limits_.brakes_for() - force) / limits_.stiffness);
}

// What the force may be, of which `force` is observed.
double Supervisor::by_now(const Eigen::Vector3d& force) const noexcept {
  return force.norm() + limits_.stiffness * unseen_;
}

void Supervisor::note(Intervention kind, bool now) noexcept {
  bool& before = going_on_[static_cast<std::size_t>(kind)];
  supervision_[kind] += now && !before;
  before = now;
}

MakeController supervised(const MakeController& make, const SupervisorLimits& limits) {
  return [make, limits](std::uint64_t trial) {
    return std::make_unique<Supervisor>(make(trial), limits);
  };
}

}  // namespace ferrule
