// A controller: from an observation of the insertion to how the hand would move.
//
// It lives in the hand's world (haptic/scaling.hpp), the world it was learned in; a trial scales
// the fibre's force up to it and its velocity down to the tip with the scene's one Scaling.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "controller/observation.hpp"
#include "controller/supervision.hpp"

namespace ferrule {

// Serves one trial: it may remember what it observed before.
class Controller {
 public:
  virtual ~Controller() = default;
  // Called once per period, from the start on: velocity of the hand until the next tick [m/s,
  // rad/s]. Must be finite; a trial checks.
  virtual HandTwist command(const Observation& observation) noexcept = 0;
  // How far the models inside are apart about the last command [m/s]; 0 for a single one.
  virtual double disagreement() const noexcept { return 0; }
  // What a supervisor did so far; null for a controller that has none.
  virtual const Supervision* supervision() const noexcept { return nullptr; }
  // Which part of its task the last command was for; empty where it knows none.
  virtual const char* phase_name() const noexcept { return ""; }
  // Is the insertion over, as far as it is concerned? Asked after a command.
  virtual bool done() const noexcept { return false; }
  // Why it cannot answer any more, where it is somebody else's program; empty while it can. Its
  // commands are not finite then.
  virtual std::string failure() const { return {}; }
};

// A new controller for trial `trial`; called from many threads at once.
using MakeController = std::function<std::unique_ptr<Controller>(std::uint64_t trial)>;

// One that starts every trial as a copy of `controller`.
template <class C>
MakeController controller_maker(const C& controller) {
  return [controller](std::uint64_t) { return std::make_unique<C>(controller); };
}

// A controller around another one: what it does not change is that of `inner`.
class ControllerWrapper : public Controller {
 public:
  explicit ControllerWrapper(std::unique_ptr<Controller> inner) : inner_(std::move(inner)) {}
  double disagreement() const noexcept override { return inner_->disagreement(); }
  const Supervision* supervision() const noexcept override { return inner_->supervision(); }
  const char* phase_name() const noexcept override { return inner_->phase_name(); }
  bool done() const noexcept override { return inner_->done(); }
  std::string failure() const override { return inner_->failure(); }

 protected:
  std::unique_ptr<Controller> inner_;
};

// The naive baseline: straight in at constant speed, whatever is observed.
class ConstantVelocity : public Controller {
 public:
  explicit ConstantVelocity(double speed) : speed_(speed) {}  // along -x [m/s], > 0
  HandTwist command(const Observation&) noexcept override {
    HandTwist v = HandTwist::Zero();
    v[0] = -speed_;
    return v;
  }

 private:
  double speed_;
};

// Depth of the hand past the entrance, which is at x = `entrance` [m].
inline double hand_depth(const HandPose& hand, double entrance = 0) noexcept {
  return hand[0] < entrance ? entrance - hand[0] : 0.0;
}

// Cuts the translation of `velocity` to `speed` [m/s], direction kept.
inline HandTwist limit_speed(HandTwist velocity, double speed) noexcept {
  const double squared = velocity.head<3>().squaredNorm();
  if (squared > speed * speed) velocity.head<3>() *= speed / std::sqrt(squared);
  return velocity;
}

}  // namespace ferrule
